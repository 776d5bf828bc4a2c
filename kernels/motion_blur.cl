/* The rendered view as a camera sees it whose shutter is open while the object moves: each pixel is the mean of where
   its surface comes from and goes to during the exposure (equation 6a of docs/math.md). */

/* Interleaved pixels (premultiplied by coverage) and depth -> the same, averaged over `taps` moments. Pixels without
   surface stay empty: coverage says at the silhouette how much of the exposure the object was there. */
__kernel void motion_blur(__global const float* in, __global const float* depth, hf_layout layout, hf_rect rect,
                          hf_exposure exposure, __global float* out) {
  const int y = rect.y + (int)get_global_id(1);
  const float last_x = rect.x + rect.width - 1, last_y = rect.y + rect.height - 1;
  for (int i = ROW_X_BEGIN; i < ROW_X_END(rect.width); ++i) {
    const int x = rect.x + i;
    const int e = element(layout, x, y);
    const float z = depth[e];
    float4 sum = (float4)(0.0f);
    if (z > 0.0f) {
      const float px = (x - exposure.cx) / exposure.fx, py = (y - exposure.cy) / exposure.fy;
      const float dx = exposure.v[0] + (exposure.w[1] - exposure.w[2] * py) * z;
      const float dy = exposure.v[1] + (exposure.w[2] * px - exposure.w[0]) * z;
      const float dz = exposure.v[2] + (exposure.w[0] * py - exposure.w[1] * px) * z;
      const float flow_x = exposure.fx * (dx - px * dz) / z, flow_y = exposure.fy * (dy - py * dz) / z;
      for (int k = 0; k < exposure.taps; ++k) {
        const float t = (k + 0.5f) / exposure.taps - 0.5f;
        const float sx = clamp(x - t * flow_x, (float)rect.x, last_x),
                    sy = clamp(y - t * flow_y, (float)rect.y, last_y);
        const float left = floor(sx), top = floor(sy);
        const float u = sx - left, v = sy - top;
        __global const float* p = in + HF_PIXEL * element(layout, (int)left, (int)top);
        float8 upper = LOAD8(p), lower = LOAD8(p + HF_PIXEL * layout.stride);
        if (exposure.light) { /* coverage is 0 or 1 here: its square is itself */
          upper *= upper;
          lower *= lower;
        }
        const float8 both = fma((float8)(v), lower - upper, upper);
        sum += fma((float4)(u), both.hi - both.lo, both.lo);
      }
      sum = sum / (float)exposure.taps;
      if (exposure.light) sum.xyz = sqrt(sum.xyz * sum.w);
    }
    vstore4(sum, 0, out + HF_PIXEL * e);
  }
}
