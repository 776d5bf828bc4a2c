/* The rendered view as a camera sees it whose shutter is open while the object moves: each pixel is the mean of where
   its surface comes from and goes to during the exposure (equation 6a of docs/math.md). */

/* Where a pixel's surface comes from in the image, over the whole exposure. */
INLINE void flow_of(lane_float x, float y, lane_float z, hf_exposure e, lane_float* flow_x, lane_float* flow_y) {
  const lane_float px = (x - e.cx) / e.fx;
  const float py = (y - e.cy) / e.fy;
  const lane_float dx = e.v[0] + (e.w[1] - e.w[2] * py) * z;
  const lane_float dy = e.v[1] + (e.w[2] * px - e.w[0]) * z;
  const lane_float dz = e.v[2] + (e.w[0] * py - e.w[1] * px) * z;
  const lane_float along_x = e.fx * (dx - px * dz) / z;
  const lane_float along_y = e.fy * (dy - py * dz) / z;
  *flow_x = e.across ? -along_y : along_x;
  *flow_y = e.across ? along_x : along_y;
}

/* Between the four pixels around p[0], at (u, v) from it. */
INLINE float4 between(__global const float* p, int step, float u, float v, const int light) {
  float8 upper = LOAD8(p), lower = LOAD8(p + step);
  if (light) { /* coverage is 0 or 1 here: its square is itself */
    upper *= upper;
    lower *= lower;
  }
  const float8 both = fma((float8)(v), lower - upper, upper);
  return fma((float4)(u), both.hi - both.lo, both.lo);
}

/* The mean of as many moments as were added up. */
INLINE float4 mean_of(float4 sum, int taps, const int light) {
  sum = sum / (float)taps;
  if (light) sum.xyz = sqrt(sum.xyz * sum.w);
  return sum;
}

/* The lanes of a row from column x on: the mean, over the moments, of what is drawn where their surface is then. Beyond
   `rect` its border goes on. */
INLINE void motion_blur_lanes(__global const float* in, __global const float* depth, hf_layout layout, hf_rect rect,
                              hf_exposure exposure, int x, int y, const int light, __global float* out) {
  const int e = element(layout, x, y), step = HF_PIXEL * layout.stride;
  const lane_float z = LOAD(depth + e);
  const lane_int wanted = z > 0.0f;
  const lane_float column = (lane_float)(x) + LANE_INDEX;
  const float last_x = rect.x + rect.width - 1, last_y = rect.y + rect.height - 1;
#if HF_STRIPS
  const float16 zero = (float16)(0.0f);
  if (!any(wanted)) {
    for (int i = 0; i < 16 * HF_PIXEL; i += 16) STORE(zero, out + HF_PIXEL * e + i);
    return;
  }
  float16 flow_x, flow_y;
  flow_of(column, y, select((float16)(1.0f), z, wanted), exposure, &flow_x, &flow_y);
  float u[16 * HF_MOST_TAPS], v[16 * HF_MOST_TAPS];
  int offset[16 * HF_MOST_TAPS], want[16];
  for (int k = 0; k < exposure.taps; ++k) {
    const float t = (k + 0.5f) / exposure.taps - 0.5f;
    const float16 sx = clamp(column - t * flow_x, (float)rect.x, last_x);
    const float16 sy = clamp((float)y - t * flow_y, (float)rect.y, last_y);
    const float16 left = floor(sx), top = floor(sy);
    STORE_PRIVATE(sx - left, u + 16 * k);
    STORE_PRIVATE(sy - top, v + 16 * k);
    vstore16((convert_int16(top) * layout.stride + convert_int16(left) + layout.origin) * HF_PIXEL, k, offset);
  }
  vstore16(wanted, 0, want);
  for (int lane = 0; lane < 16; ++lane) {
    float4 sum = (float4)(0.0f);
    if (want[lane]) {
      for (int i = lane; i < 16 * exposure.taps; i += 16) sum += between(in + offset[i], step, u[i], v[i], light);
      sum = mean_of(sum, exposure.taps, light);
    }
    vstore4(sum, 0, out + HF_PIXEL * (e + lane));
  }
#else
  float4 sum = (float4)(0.0f);
  if (wanted) {
    float flow_x, flow_y;
    flow_of(column, y, z, exposure, &flow_x, &flow_y);
    for (int k = 0; k < exposure.taps; ++k) {
      const float t = (k + 0.5f) / exposure.taps - 0.5f;
      const float sx = clamp(column - t * flow_x, (float)rect.x, last_x);
      const float sy = clamp(y - t * flow_y, (float)rect.y, last_y);
      const float left = floor(sx), top = floor(sy);
      sum += between(in + HF_PIXEL * element(layout, (int)left, (int)top), step, sx - left, sy - top, light);
    }
    sum = mean_of(sum, exposure.taps, light);
  }
  vstore4(sum, 0, out + HF_PIXEL * e);
#endif
}

/* Interleaved pixels (premultiplied by coverage) and depth -> the same, averaged over `taps` moments, HF_MOST_TAPS at
   most; `rect` in whole tiles. Pixels without surface stay empty: coverage says at the silhouette how much of the
   exposure the object was there. */
__kernel void motion_blur(__global const float* in, __global const float* depth, hf_layout layout, hf_rect rect,
                          hf_exposure exposure, __global float* out) {
  const int y = rect.y + (int)get_global_id(1);
  for (int i = ROW_X_BEGIN; i < ROW_X_END(rect.width); i += LANES) {
    if (exposure.light) {
      motion_blur_lanes(in, depth, layout, rect, exposure, rect.x + i, y, 1, out);
    } else {
      motion_blur_lanes(in, depth, layout, rect, exposure, rect.x + i, y, 0, out);
    }
  }
}
