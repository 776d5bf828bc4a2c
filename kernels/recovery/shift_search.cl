/* How well the frame's gradients agree with the rendered view's when the view is shifted by whole pixels: one score a
   shift, bounded a pixel, so that neither light nor partial occlusion decides (equation 14 of docs/math.md). */

/* Blurred frame -> planes that shifts are looked up in: d/dx and d/dy of three channels, squared length. */
__kernel void frame_gradients(__global const float* frame, hf_layout layout, hf_rect rect, __global float* out,
                              int plane) {
  const int y = rect.y + (int)get_global_id(1);
  const int step = HF_PIXEL * layout.stride;
  for (int i = ROW_X_BEGIN; i < ROW_X_END(rect.width); i += PIXELS_AT_ONCE) {
    const int e = element(layout, rect.x + i, y);
    __global const float* p = frame + HF_PIXEL * e;
    const pixel_vector gx = 0.5f * (LOAD_PIXELS(p + HF_PIXEL) - LOAD_PIXELS(p - HF_PIXEL));
    const pixel_vector gy = 0.5f * (LOAD_PIXELS(p + step) - LOAD_PIXELS(p - step));
    const pixel_vector squares = fma(gx, gx, gy * gy);
    STORE_LANE(CHANNEL_0(gx), out + e);
    STORE_LANE(CHANNEL_1(gx), out + e + plane);
    STORE_LANE(CHANNEL_2(gx), out + e + 2 * plane);
    STORE_LANE(CHANNEL_0(gy), out + e + 3 * plane);
    STORE_LANE(CHANNEL_1(gy), out + e + 4 * plane);
    STORE_LANE(CHANNEL_2(gy), out + e + 5 * plane);
    STORE_LANE(CHANNEL_0(squares) + CHANNEL_1(squares) + CHANNEL_2(squares), out + e + 6 * plane);
  }
}

/* LANES neighbouring shifts of a row of shifts: `width` shifts a row from `first` on, as many rows as
   get_global_size(1). */
__kernel void shift_scores(__global const float* dx, __global const float* dy, int plane, __global const uchar* usable,
                           hf_layout layout, hf_rect rect, int step, __global const float* gradients,
                           int gradient_plane, int4 sampled, int2 first, int width, __global float* scores) {
  const int column = LANES * (int)get_global_id(0);
  const int first_x = first.x + column, shift_y = first.y + (int)get_global_id(1);
  lane_float agreement = (lane_float)(0.0f);
  float weight = 0.0f;
  for (int y = rect.y; y < rect.y + rect.height; y += step) {
    for (int x = rect.x; x < rect.x + rect.width; x += step) {
      const int e = element(layout, x, y);
      if (usable[e] != HF_USED) continue;
      /* Channels written out: llvmpipe ends a kernel's loops after 65,535 passes in all. */
      const float vx0 = dx[e], vx1 = dx[e + plane], vx2 = dx[e + 2 * plane];
      const float vy0 = dy[e], vy1 = dy[e + plane], vy2 = dy[e + 2 * plane];
      const float mv2 = vx0 * vx0 + vy0 * vy0 + vx1 * vx1 + vy1 * vy1 + vx2 * vx2 + vy2 * vy2;
      if (mv2 < 1e-5f) continue;
      const float mv = sqrt(mv2);
      weight += mv;
      const int v = y + shift_y;
      if (v < sampled.y || v > sampled.w) continue;
      const lane_float u = (lane_float)(x + first_x) + LANE_INDEX;
      const lane_int inside = (u >= (float)sampled.x) & (u <= (float)sampled.z);
      if (!ANY(inside)) continue;
      __global const float* p = gradients + element(layout, x + first_x, v);
      lane_float along = vx0 * LOAD(p);
      along = fma((lane_float)(vx1), LOAD(p + gradient_plane), along);
      along = fma((lane_float)(vx2), LOAD(p + 2 * gradient_plane), along);
      along = fma((lane_float)(vy0), LOAD(p + 3 * gradient_plane), along);
      along = fma((lane_float)(vy1), LOAD(p + 4 * gradient_plane), along);
      along = fma((lane_float)(vy2), LOAD(p + 5 * gradient_plane), along);
      const lane_float scale = 0.5f * (mv2 + LOAD(p + 6 * gradient_plane)) + 1e-5f;
      agreement += select((lane_float)(0.0f), mv * along / scale, inside);
    }
  }
  __global float* row = scores + (int)get_global_id(1) * width;
#if HF_STRIPS
  float lanes[16];
  vstore16(agreement, 0, lanes);
  for (int i = 0; i < 16 && column + i < width; ++i) row[column + i] = weight > 0.0f ? lanes[i] / weight : 0.0f;
#else
  row[column] = weight > 0.0f ? agreement / weight : 0.0f;
#endif
}
