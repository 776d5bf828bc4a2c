/* Filters on interleaved pixels (three channels, coverage). Channels of an unfiltered pixel are premultiplied by its
   coverage, so that one linear filter blurs colour and mask together and what is not covered has no weight (equation 6
   of docs/math.md). */

/* The mean of 2x2 pixels; `rect` in pixels of the coarser level. */
__kernel void halve(__global const float* in, hf_layout in_layout, hf_rect rect, hf_layout out_layout,
                    __global float* out) {
  const int y = rect.y + (int)get_global_id(1);
  for (int i = ROW_X_BEGIN; i < ROW_X_END(rect.width); ++i) {
    const int x = rect.x + i;
    __global const float* p = in + HF_PIXEL * element(in_layout, 2 * x, 2 * y);
    const float8 top = vload8(0, p), bottom = vload8(0, p + HF_PIXEL * in_layout.stride);
    const float8 sum = top + bottom;
    vstore4(0.25f * (sum.lo + sum.hi), 0, out + HF_PIXEL * element(out_layout, x, y));
  }
}

/* One side's taps and the centre, with a constant number of taps where that is common: the loop then unrolls. */
#define BLUR_SUM(STEP, RADIUS)                                                                              \
  for (int k = 1; k <= (RADIUS); ++k) {                                                                     \
    sum = fma((pixel_vector)(taps[k]), LOAD_PIXELS(in + e - (STEP) * k) + LOAD_PIXELS(in + e + (STEP) * k), sum); \
  }
#define BLUR(STEP)                  \
  pixel_vector sum = taps[0] * LOAD_PIXELS(in + e); \
  if (radius == 3) {                \
    BLUR_SUM(STEP, 3)               \
  } else {                          \
    BLUR_SUM(STEP, radius)          \
  }

/* Row pass of the separable Gaussian: taps[0] is the centre. */
__kernel void blur_rows(__global const float* in, hf_layout layout, hf_rect rect, __constant float* taps, int radius,
                        __global float* out) {
  const int y = rect.y + (int)get_global_id(1);
  for (int i = ROW_X_BEGIN; i < ROW_X_END(rect.width); i += PIXELS_AT_ONCE) {
    const int e = HF_PIXEL * element(layout, rect.x + i, y);
    BLUR(HF_PIXEL)
    STORE_PIXELS(sum, out + e);
  }
}

/* Channels divided by coverage; coverage kept. */
float4 normalized_pixel(float4 p) {
  const float coverage = p.w;
  const float scale = coverage > 1e-4f ? 1.0f / coverage : 0.0f;
  return (float4)(p.xyz * scale, coverage);
}

#if HF_STRIPS
pixel_vector normalized_pixels(pixel_vector p) {
  return (pixel_vector)(normalized_pixel(p.s0123), normalized_pixel(p.s4567), normalized_pixel(p.s89ab),
                        normalized_pixel(p.scdef));
}
#else
pixel_vector normalized_pixels(pixel_vector p) { return normalized_pixel(p); }
#endif

/* Column pass, then normalisation by coverage. */
__kernel void blur_columns(__global const float* in, hf_layout layout, hf_rect rect, __constant float* taps, int radius,
                           __global float* out) {
  const int y = rect.y + (int)get_global_id(1);
  for (int i = ROW_X_BEGIN; i < ROW_X_END(rect.width); i += PIXELS_AT_ONCE) {
    const int e = HF_PIXEL * element(layout, rect.x + i, y);
    const int step = HF_PIXEL * layout.stride;
    BLUR(step)
    STORE_PIXELS(normalized_pixels(sum), out + e);
  }
}

/* Central differences, intensity a pixel; value and both derivatives side by side. */
__kernel void image_features(__global const float* in, hf_layout layout, hf_rect rect, __global float* out) {
  const int y = rect.y + (int)get_global_id(1);
  for (int i = ROW_X_BEGIN; i < ROW_X_END(rect.width); ++i) {
    const int e = element(layout, rect.x + i, y);
    __global const float* p = in + HF_PIXEL * e;
    const int step = HF_PIXEL * layout.stride;
    const float4 value = vload4(0, p);
    const float4 dx = 0.5f * (vload4(0, p + HF_PIXEL) - vload4(0, p - HF_PIXEL));
    const float4 dy = 0.5f * (vload4(0, p + step) - vload4(0, p - step));
    __global float* o = out + HF_FEATURE * e;
    vstore3(value.xyz, 0, o);
    vstore3(dx.xyz, 1, o);
    vstore3(dy.xyz, 2, o);
  }
}
