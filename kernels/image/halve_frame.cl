#if HF_STRIPS
/* Frames as cameras deliver them (no distortion) -> what converting and halving makes of them, the same bits. */

/* Means of two by two pixels of a row and the one below: eight, twice. */
INLINE float16 halved(float16 upper, float16 lower) {
  const float16 sums = upper + lower;
  const float8 mean = 0.25f * (sums.even + sums.odd);
  return (float16)(mean, mean);
}

/* Eight pixels at once; `rect` in pixels of the coarser level, as wide as whole vectors of four. */
INLINE void halve_rows(__global const uchar* frame, hf_frame f, const int format, hf_rect rect, int y, hf_layout layout,
                       __global float* out) {
  __global const uchar* upper_row = frame + f.offset + 2 * y * f.stride;
  const int upper_width = 2 * y < f.height ? f.width : 0, lower_width = 2 * y + 1 < f.height ? f.width : 0;
  for (int i = 0; i < rect.width; i += 8) {
    const int x = rect.x + i;
    float16 upper[LINE], lower[LINE], mean[HF_PIXEL];
    take_bytes_apart(frame_pixels(upper_row, upper_width, format, 2 * x), HF_PIXEL, upper);
    take_bytes_apart(frame_pixels(upper_row + f.stride, lower_width, format, 2 * x), HF_PIXEL, lower);
    for (int c = 0; c < HF_PIXEL; ++c) mean[c] = halved(upper[c * LINE_VECTORS], lower[c * LINE_VECTORS]);
    store_interleaved(mean[0], mean[1], mean[2], mean[3], min(8, rect.width - i),
                      out + HF_PIXEL * element(layout, x, y));
  }
}

#define HALVE_FRAME_KERNEL(NAME, FORMAT)                                                                             \
  __kernel void NAME(__global const uchar* frame, hf_frame f, hf_rect rect, hf_layout layout, __global float* out) { \
    halve_rows(frame, f, FORMAT, rect, rect.y + (int)get_global_id(1), layout, out);                                 \
  }

HALVE_FRAME_KERNEL(halve_bgr8, HF_BGR8)
HALVE_FRAME_KERNEL(halve_rgb8, HF_RGB8)
HALVE_FRAME_KERNEL(halve_rgba8, HF_RGBA8)
HALVE_FRAME_KERNEL(halve_grey8, HF_GREY8)
#endif
