/* Strips: the Gaussian and what follows it, a block of pixels at a time (equation 6 of docs/math.md). Rows of the
   source are taken apart by channel, so that sixteen pixels are one vector, and summed along; the last rows summed (the
   ring) are then summed across, so that nothing leaves the nearest cache in between. */
#if HF_STRIPS
#define RING_ROWS (2 * HF_BLUR_RADIUS + 1)
/* Vectors of a block's row and a pixel more on both sides, and of what the blur of that reaches. */
#define ROW_VECTORS (HF_BLUR_COLUMNS / 16 + 1)
#define LINE_VECTORS ((16 * ROW_VECTORS + 2 * HF_BLUR_RADIUS + 15) / 16)
#define ROW (HF_PIXEL * ROW_VECTORS)
#define LINE (HF_PIXEL * LINE_VECTORS)

/* The item's block of `rect`, whole tiles wide but for the last. */
INLINE hf_rect block_of(hf_rect rect) {
  const int across = (int)get_num_groups(0);
  const int columns = (rect.width + HF_TILE * across - 1) / (HF_TILE * across) * HF_TILE;
  const int x = columns * (int)get_group_id(0), y = HF_BLUR_ROWS * (int)get_group_id(1);
  hf_rect block;
  block.x = rect.x + x;
  block.y = rect.y + y;
  block.width = min(columns, rect.width - x);
  block.height = min(HF_BLUR_ROWS, rect.height - y);
  return block;
}

/* Whether all that the blur of `block` meets lies in `covered`. */
INLINE int all_covered(hf_rect block, hf_rect covered) {
  return block.x - HF_BLUR_RADIUS >= covered.x && block.y - HF_BLUR_RADIUS >= covered.y &&
         block.x + block.width + HF_BLUR_RADIUS <= covered.x + covered.width &&
         block.y + block.height + HF_BLUR_RADIUS <= covered.y + covered.height;
}

/* Sixteen interleaved pixels from p on, taken apart into a line. */
INLINE void take_apart(__global const float* p, const int channels, float16* line) {
  const ulong8 a = as_ulong8(LOAD(p)), b = as_ulong8(LOAD(p + 16)), c = as_ulong8(LOAD(p + 32)),
               d = as_ulong8(LOAD(p + 48));
  const float16 first = as_float16((ulong8)(a.even, b.even)), second = as_float16((ulong8)(c.even, d.even));
  const float16 third = as_float16((ulong8)(a.odd, b.odd)), fourth = as_float16((ulong8)(c.odd, d.odd));
  line[0] = (float16)(first.even, second.even);
  line[LINE_VECTORS] = (float16)(first.odd, second.odd);
  line[2 * LINE_VECTORS] = (float16)(third.even, fourth.even);
  if (channels == 4) line[3 * LINE_VECTORS] = (float16)(third.odd, fourth.odd);
}

/* The same of pixels of four bytes, of which the last is 0 where nothing is covered. */
INLINE void take_bytes_apart(uint16 pixels, const int channels, float16* line) {
  const float byte = 1.0f / 255.0f;
  line[0] = byte * convert_float16(as_int16(pixels & 255));
  line[LINE_VECTORS] = byte * convert_float16(as_int16((pixels >> 8) & 255));
  line[2 * LINE_VECTORS] = byte * convert_float16(as_int16((pixels >> 16) & 255));
  if (channels == 4) {
    line[3 * LINE_VECTORS] = select((float16)(0.0f), (float16)(1.0f), (pixels >> 24) != 0);
  }
}

/* Along a line: `vectors` of each channel, of which the first pixel is HF_BLUR_RADIUS behind the line's. */
INLINE void sum_along(const float16* line, const int channels, int vectors, float16* row) {
  for (int c = 0; c < channels; ++c) {
    const float* p = (const float*)(line + c * LINE_VECTORS);
    for (int v = 0; v < vectors; ++v, p += 16) {
      row[c * ROW_VECTORS + v] =
          gaussian(LOAD_PRIVATE(p + 3), LOAD_PRIVATE(p + 2) + LOAD_PRIVATE(p + 4),
                   LOAD_PRIVATE(p + 1) + LOAD_PRIVATE(p + 5), LOAD_PRIVATE(p) + LOAD_PRIVATE(p + 6));
    }
  }
}

/* The rows that the sum across row y of a block takes, from top to bottom. */
INLINE void rows_around(const float16* ring, int y, const float16** rows) {
  for (int k = 0; k < RING_ROWS; ++k) rows[k] = ring + (y + k) % RING_ROWS * ROW;
}

INLINE float16 sum_across(const float16** rows, int i) {
  return gaussian(rows[3][i], rows[2][i] + rows[4][i], rows[1][i] + rows[5][i], rows[0][i] + rows[6][i]);
}

INLINE float16 inverse_of_coverage(float16 coverage) {
  const int16 covered = coverage > 1e-4f;
  return select((float16)(0.0f), 1.0f / select((float16)(1.0f), coverage, covered), covered);
}

/* Row y of a block, from the ring: blurred and normalised interleaved pixels. With three channels all of it is
   covered. */
INLINE void store_blurred(const float16* ring, int y, const int channels, int columns, __global float* out) {
  const float16* rows[RING_ROWS];
  rows_around(ring, y, rows);
  /* What the sums make of a coverage of 1 everywhere: 1 but for roundings. */
  const float16 along = gaussian((float16)(1.0f), (float16)(2.0f), (float16)(2.0f), (float16)(2.0f));
  const float16 full = gaussian(along, along + along, along + along, along + along);
  for (int v = 0; 16 * v < columns; ++v, out += 16 * HF_PIXEL) {
    const float16 coverage = channels == 4 ? sum_across(rows, 3 * ROW_VECTORS + v) : full;
    const float16 inverse = channels == 4 ? inverse_of_coverage(coverage) : 1.0f / full;
    const float16 r = inverse * sum_across(rows, v), g = inverse * sum_across(rows, ROW_VECTORS + v);
    const float16 b = inverse * sum_across(rows, 2 * ROW_VECTORS + v);
    store_interleaved(r, g, b, coverage, columns - 16 * v, out);
  }
}

/* Pixel x of a row of `width`, outside of which nothing is covered: red, green, blue and coverage in four bytes. */
INLINE uint frame_pixel(__global const uchar* row, int width, const int format, int x) {
  if (x < 0 || x >= width) return 0;
  if (format == HF_GREY8) return 0xff000000u | row[x];
  if (format == HF_RGBA8) return 0xff000000u | (row[4 * x + 2] << 16) | (row[4 * x + 1] << 8) | row[4 * x];
  const uint first = row[3 * x], last = row[3 * x + 2];
  return 0xff000000u | (row[3 * x + 1] << 8) | (format == HF_BGR8 ? first << 16 | last : last << 16 | first);
}

/* Sixteen of them from x on. No byte behind the row is read. */
INLINE uint16 frame_pixels(__global const uchar* row, int width, const int format, int x) {
  if (x >= 0 && x + 18 <= width) {
    if (format == HF_GREY8) return 0xff000000u | convert_uint16(LOAD_BYTES(row + x));
    if (format == HF_RGBA8) return 0xff000000u | as_uint16(LOAD((__global const float*)(row + 4 * x)));
    const uchar16 a = LOAD_BYTES(row + 3 * x), b = LOAD_BYTES(row + 3 * x + 12);
    const uchar16 c = LOAD_BYTES(row + 3 * x + 24), d = LOAD_BYTES(row + 3 * x + 36);
#define IN_ORDER(v) as_uint4((v).s0120345067809ab0)
#define TURNED(v) as_uint4((v).s210054308760ba90)
    return 0xff000000u | (format == HF_BGR8 ? (uint16)(TURNED(a), TURNED(b), TURNED(c), TURNED(d))
                                            : (uint16)(IN_ORDER(a), IN_ORDER(b), IN_ORDER(c), IN_ORDER(d)));
  }
  uint pixels[16];
  for (int i = 0; i < 16; ++i) pixels[i] = frame_pixel(row, width, format, x + i);
  return vload16(0, pixels);
}

/* A block, from interleaved pixels or, where there are none, from a frame. */
INLINE void blur_block(__global const float* in, __global const uchar* frame, hf_frame f, const int format,
                       hf_layout layout, hf_rect block, const int channels, __global float* out) {
  float16 line_pair[2 * LINE], ring[RING_ROWS * ROW];
  const int vectors = (block.width + 15) / 16, lines = (block.width + RING_ROWS + 14) / 16;
  const int count = block.height + RING_ROWS - 1, x = block.x - HF_BLUR_RADIUS;
  /* A line is summed when the next one is taken apart: what was stored just now would be waited for. */
  for (int i = 0; i <= count; ++i) {
    if (i < count) {
      const int y = block.y - HF_BLUR_RADIUS + i;
      float16* line = line_pair + i % 2 * LINE;
      const int width = y >= 0 && y < f.height ? f.width : 0;
      for (int v = 0; v < lines; ++v) {
        if (in) {
          take_apart(in + HF_PIXEL * element(layout, x + 16 * v, y), channels, line + v);
        } else {
          const uint16 pixels = frame_pixels(frame + f.offset + y * f.stride, width, format, x + 16 * v);
          take_bytes_apart(pixels, channels, line + v);
        }
      }
    }
    if (i > 0) sum_along(line_pair + (i - 1) % 2 * LINE, channels, vectors, ring + (i - 1) % RING_ROWS * ROW);
    const int y = i - RING_ROWS;
    if (y < 0) continue;
    store_blurred(ring, y, channels, block.width, out + HF_PIXEL * element(layout, block.x, block.y + y));
  }
}

/* The item's block of `rect`. In `covered` all coverage is 1. */
INLINE void blur_rect(__global const float* in, __global const uchar* frame, hf_frame f, const int format,
                      hf_layout layout, hf_rect rect, __global float* out, hf_rect covered) {
  const hf_rect block = block_of(rect);
  if (all_covered(block, covered)) {
    blur_block(in, frame, f, format, layout, block, 3, out);
  } else {
    blur_block(in, frame, f, format, layout, block, 4, out);
  }
}

/* Interleaved pixels, premultiplied by coverage -> blurred, divided by coverage. */
__kernel void blur(__global const float* in, hf_layout layout, hf_rect rect, __global float* out, hf_rect covered) {
  hf_frame none;
  none.width = none.height = 0;
  blur_rect(in, 0, none, HF_BGR8, layout, rect, out, covered);
}

/* Frames as cameras deliver them (no distortion) -> what converting and blurring makes of them. */
#define BLUR_FRAME_KERNEL(NAME, FORMAT)                                                                              \
  __kernel void NAME(__global const uchar* frame, hf_frame f, hf_layout layout, hf_rect rect, __global float* out) { \
    const hf_rect covered = {0, 0, f.width, f.height};                                                               \
    blur_rect(0, frame, f, FORMAT, layout, rect, out, covered);                                                      \
  }

BLUR_FRAME_KERNEL(blur_bgr8, HF_BGR8)
BLUR_FRAME_KERNEL(blur_rgb8, HF_RGB8)
BLUR_FRAME_KERNEL(blur_rgba8, HF_RGBA8)
BLUR_FRAME_KERNEL(blur_grey8, HF_GREY8)
#endif
