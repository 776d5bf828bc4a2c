/* The rendered view -> what the constraints compare the frame with: planes of value, gradient, depth and usability. */

/* Packed render -> interleaved pixels (premultiplied by 'known surface') and metric depth, 0 where empty. */
__kernel void unpack_view(__global const uchar* rgba, __global const float* window_depth, hf_view view, hf_rect rect,
                          hf_layout layout, __global float* pixels, __global float* depth) {
  const int row = (int)get_global_id(1);
  for (int i = ROW_X_BEGIN; i < ROW_X_END(rect.width); i += PIXELS_AT_ONCE) {
    const int source = row * view.stride + i;
    const int e = element(layout, rect.x + i, rect.y + row);
    const pixel_lane d = LOAD_LANE(window_depth + source);
    const pixel_lane z = view.near_plane * view.far_plane / (view.far_plane - d * (view.far_plane - view.near_plane));
    const pixel_mask drawn = d < 1.0f;
    STORE_LANE(CHOOSE((pixel_lane)(0.0f), z, drawn), depth + e);
    const pixel_vector bytes = CONVERT_PIXELS(LOAD_PIXEL_BYTES(rgba + 4 * source));
    const pixel_lane known = CHOOSE((pixel_lane)(0.0f), (pixel_lane)(1.0f), drawn & (CHANNEL_3(bytes) > 0.0f));
    pixel_lane red = CHANNEL_0(bytes) * known * (1.0f / 255.0f), green = CHANNEL_1(bytes) * known * (1.0f / 255.0f);
    pixel_lane blue = CHANNEL_2(bytes) * known * (1.0f / 255.0f);
    if (view.grey) {
      red = 0.299f * red + 0.587f * green + 0.114f * blue;
      green = blue = (pixel_lane)(0.0f);
    }
    STORE_PIXELS(INTERLEAVED(red, green, blue, known), pixels + HF_PIXEL * e);
  }
}

/* Depth of the coarser level: the mean of those of the 2x2 pixels that are drawn. */
__kernel void halve_depth(__global const float* in, hf_layout in_layout, hf_rect rect, hf_layout out_layout,
                          __global float* out) {
  const int y = rect.y + (int)get_global_id(1);
  for (int i = ROW_X_BEGIN; i < ROW_X_END(rect.width); ++i) {
    const int x = rect.x + i;
    __global const float* p = in + element(in_layout, 2 * x, 2 * y);
    const float4 z = (float4)(p[0], p[1], p[in_layout.stride], p[in_layout.stride + 1]);
    const float count = dot((float4)(1.0f), select((float4)(0.0f), (float4)(1.0f), z > 0.0f));
    out[element(out_layout, x, y)] = count > 0.0f ? (z.x + z.y + z.z + z.w) / count : 0.0f;
  }
}

pixel_mask depth_jump(pixel_lane z, pixel_lane other, float relative) {
  return (other <= 0.0f) | (fabs(other - z) > relative * z);
}

/* 1/Z is linear in the image on a plane: whether it bends between two pixels `step` elements either way. */
INLINE pixel_mask bent(__global const float* depth, int step, float relative) {
  const pixel_lane z = LOAD_LANE(depth), before = LOAD_LANE(depth - step), after = LOAD_LANE(depth + step);
  return (before > 0.0f) & (after > 0.0f) & (fabs(z / before + z / after - 2.0f) > relative);
}

/* Blurred, normalised pixels -> planes. Usable: covered at least `least_coverage` within the blur's reach and no depth
   jump or hole within `reach` pixels in the row and the column, nor, where `bend` is above 0, an edge between faces
   within three; `usable` is 0 outside the object (and outside the
   frame of width x height), HF_UNUSABLE or HF_USED. The planes are written where the object is. */
__kernel void template_planes(__global const float* in, __global const float* depth, hf_layout layout, hf_rect rect,
                              int width, int height, float least_coverage, float jump, int reach, __global float* value,
                              __global float* dx, __global float* dy, int plane, __global uchar* usable, float bend) {
  const int y = rect.y + (int)get_global_id(1);
  for (int i = ROW_X_BEGIN; i < ROW_X_END(rect.width); i += PIXELS_AT_ONCE) {
    const int e = element(layout, rect.x + i, y);
    const pixel_lane z = LOAD_LANE(depth + e);
    const pixel_mask visible = (z > 0.0f) & ((pixel_mask)(rect.x + i) + PIXEL_INDEX < width) & (y < height ? ~0 : 0);
    if (NO_PIXEL(visible)) {
      STORE_STATE((pixel_mask)(HF_NOT_VISIBLE), usable + e);
      continue;
    }
    __global const float* p = in + HF_PIXEL * e;
    const int step = HF_PIXEL * layout.stride;
    const pixel_vector v = LOAD_PIXELS(p), left = LOAD_PIXELS(p - HF_PIXEL), right = LOAD_PIXELS(p + HF_PIXEL);
    const pixel_vector up = LOAD_PIXELS(p - step), down = LOAD_PIXELS(p + step);
    const pixel_vector gx = 0.5f * (right - left), gy = 0.5f * (down - up);
    pixel_mask good = (CHANNEL_3(v) >= least_coverage) & (CHANNEL_3(left) > 0.25f) & (CHANNEL_3(right) > 0.25f) &
                      (CHANNEL_3(up) > 0.25f) & (CHANNEL_3(down) > 0.25f);
    for (int k = 1; k <= reach; ++k) {
      const pixel_mask broken = depth_jump(z, LOAD_LANE(depth + e - k), jump) |
                                depth_jump(z, LOAD_LANE(depth + e + k), jump) |
                                depth_jump(z, LOAD_LANE(depth + e - k * layout.stride), jump) |
                                depth_jump(z, LOAD_LANE(depth + e + k * layout.stride), jump);
      good &= !broken;
    }
    if (bend > 0.0f) {
      good &= !(bent(depth + e, 1, bend) | bent(depth + e, 3, bend) | bent(depth + e, layout.stride, bend) |
                bent(depth + e, 3 * layout.stride, bend));
    }
    pixel_mask state = CHOOSE((pixel_mask)(HF_UNUSABLE), (pixel_mask)(HF_USED), good);
    state = CHOOSE((pixel_mask)(HF_NOT_VISIBLE), state, visible);
    STORE_STATE(state, usable + e);
    STORE_LANE(CHANNEL_0(v), value + e);
    STORE_LANE(CHANNEL_1(v), value + e + plane);
    STORE_LANE(CHANNEL_2(v), value + e + 2 * plane);
    STORE_LANE(CHANNEL_0(gx), dx + e);
    STORE_LANE(CHANNEL_1(gx), dx + e + plane);
    STORE_LANE(CHANNEL_2(gx), dx + e + 2 * plane);
    STORE_LANE(CHANNEL_0(gy), dy + e);
    STORE_LANE(CHANNEL_1(gy), dy + e + plane);
    STORE_LANE(CHANNEL_2(gy), dy + e + 2 * plane);
  }
}
