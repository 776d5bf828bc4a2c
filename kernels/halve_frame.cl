#if HF_STRIPS
/* Frames as cameras deliver them (no distortion) -> what converting and halving makes of them, the same bits. */

/* Channel sums of sixteen pixels and of those below, four bytes each. */
INLINE float16 column_sums(uint16 upper, uint16 lower, const int shift) {
  const float byte = 1.0f / 255.0f;
  return byte * convert_float16(as_int16((upper >> (uint)shift) & 255u)) +
         byte * convert_float16(as_int16((lower >> (uint)shift) & 255u));
}

INLINE float16 halved(float16 sums) {
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
    const uint16 upper = frame_pixels(upper_row, upper_width, format, 2 * x);
    const uint16 lower = frame_pixels(upper_row + f.stride, lower_width, format, 2 * x);
    const float16 covered = CHOOSE((float16)(0.0f), (float16)(1.0f), upper >> 24 != 0) +
                            CHOOSE((float16)(0.0f), (float16)(1.0f), lower >> 24 != 0);
    const float16 none = (float16)(0.0f);
    const float16 r = halved(column_sums(upper, lower, 0));
    const float16 g = format == HF_GREY8 ? none : halved(column_sums(upper, lower, 8));
    const float16 b = format == HF_GREY8 ? none : halved(column_sums(upper, lower, 16));
    store_interleaved(r, g, b, halved(covered), min(8, rect.width - i), out + HF_PIXEL * element(layout, x, y));
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
