/* Filters on interleaved pixels (three channels, coverage). Channels of an unfiltered pixel are premultiplied by its
   coverage, so that one linear filter blurs colour and mask together and what is not covered has no weight (equation 6
   of docs/math.md). */

/* The mean of 2x2 pixels; `rect` in pixels of the coarser level. */
__kernel void halve(__global const float* in, hf_layout in_layout, hf_rect rect, hf_layout out_layout,
                    __global float* out) {
  const int y = rect.y + (int)get_global_id(1);
  const int below = HF_PIXEL * in_layout.stride;
  for (int i = ROW_X_BEGIN; i < ROW_X_END(rect.width); i += PIXELS_AT_ONCE) {
    const int x = rect.x + i;
    __global const float* p = in + HF_PIXEL * element(in_layout, 2 * x, 2 * y);
    __global float* o = out + HF_PIXEL * element(out_layout, x, y);
#if HF_STRIPS
    const float16 first = LOAD(p) + LOAD(p + below), second = LOAD(p + 16) + LOAD(p + below + 16);
    const float16 even = (float16)(first.lo.lo, first.hi.lo, second.lo.lo, second.hi.lo);
    const float16 odd = (float16)(first.lo.hi, first.hi.hi, second.lo.hi, second.hi.hi);
    STORE(0.25f * (even + odd), o);
#else
    const float8 sum = vload8(0, p) + vload8(0, p + below);
    vstore4(0.25f * (sum.lo + sum.hi), 0, o);
#endif
  }
}

/* Channels divided by coverage; coverage kept. */
INLINE pixel_lane inverse_coverage(pixel_lane coverage) {
  const pixel_mask covered = coverage > 1e-4f;
  return CHOOSE((pixel_lane)(0.0f), 1.0f / CHOOSE((pixel_lane)(1.0f), coverage, covered), covered);
}

#if HF_STRIPS
INLINE float16 normalized_pixels(float16 p) {
  const float4 s = inverse_coverage(CHANNEL_3(p));
  const float one = 1.0f;
  return p * (float16)(s.s000, one, s.s111, one, s.s222, one, s.s333, one);
}
#else
float4 normalized_pixel(float4 p) { return (float4)(p.xyz * inverse_coverage(p.w), p.w); }
#endif

/* Separable Gaussian, then normalisation by coverage, a block at a time: rows are blurred into `lines` (which hold as
   many as the column pass needs at once), columns are summed from there, so that nothing leaves the nearest cache
   between the passes. taps[0] is the centre's. */
#if HF_STRIPS
#define BLOCK_COLUMNS HF_BLUR_COLUMNS
#define BLOCK_ROWS HF_BLUR_ROWS
#define LINE (HF_PIXEL * BLOCK_COLUMNS / 16)
/* The common reach written out: PoCL 3.1 does not unroll by itself. */
#define FOR_EACH_TAP                    \
  if (radius == 3) {                    \
    ADD_TAP(1) ADD_TAP(2) ADD_TAP(3)    \
  } else {                              \
    for (int k = 1; k <= radius; ++k) { \
      ADD_TAP(k)                        \
    }                                   \
  }

/* `lines` in whole vectors: no load of the column pass then straddles two lines of the cache. */
INLINE void blur_block(__global const float* in, hf_layout layout, int x0, int y0, int columns, int rows,
                       __constant float* taps, const int radius, float16* lines, __global float* out) {
  const int count = 2 * radius + 1, vectors = (HF_PIXEL * columns + 15) / 16;
  for (int i = 0; i < rows + 2 * radius; ++i) {
    float16* line = lines + (i % count) * LINE;
    __global const float* p = in + HF_PIXEL * element(layout, x0, y0 - radius + i);
    for (int x = 0; x < vectors; ++x) {
      float16 sum = taps[0] * LOAD(p + 16 * x);
#define ADD_TAP(k) \
  sum = fma((float16)(taps[k]), LOAD(p + 16 * x - HF_PIXEL * (k)) + LOAD(p + 16 * x + HF_PIXEL * (k)), sum);
      FOR_EACH_TAP
#undef ADD_TAP
      line[x] = sum;
    }
    const int row = i - 2 * radius;
    if (row < 0) continue;
    const float16* line_of[2 * HF_MAX_RADIUS + 1];
    for (int k = 0; k < count; ++k) line_of[k] = lines + ((row + k) % count) * LINE;
    __global float* o = out + HF_PIXEL * element(layout, x0, y0 + row);
    for (int x = 0; x < vectors; ++x) {
      float16 sum = taps[0] * line_of[radius][x];
#define ADD_TAP(k) sum = fma((float16)(taps[k]), line_of[radius - (k)][x] + line_of[radius + (k)][x], sum);
      FOR_EACH_TAP
#undef ADD_TAP
      STORE(normalized_pixels(sum), o + 16 * x);
    }
  }
}

__kernel void blur(__global const float* in, hf_layout layout, hf_rect rect, __constant float* taps, int radius,
                   __global float* out) {
  const int x = BLOCK_COLUMNS * (int)get_group_id(0), y = BLOCK_ROWS * (int)get_group_id(1);
  const int columns = min(BLOCK_COLUMNS, rect.width - x), rows = min(BLOCK_ROWS, rect.height - y);
  float16 lines[(2 * HF_MAX_RADIUS + 1) * LINE];
  /* The common reach as a constant, known inside the loops. */
  if (radius == 3) {
    blur_block(in, layout, rect.x + x, rect.y + y, columns, rows, taps, 3, lines, out);
  } else {
    blur_block(in, layout, rect.x + x, rect.y + y, columns, rows, taps, radius, lines, out);
  }
}
#else
__kernel void blur(__global const float* in, hf_layout layout, hf_rect rect, __constant float* taps, int radius,
                   __global float* out) {
  __local float4 lines[(HF_TILE + 2 * HF_MAX_RADIUS) * HF_TILE];
  const int x0 = rect.x + HF_TILE * (int)get_group_id(0), y0 = rect.y + HF_TILE * (int)get_group_id(1);
  for (int i = (int)get_local_id(0); i < (HF_TILE + 2 * radius) * HF_TILE; i += HF_GROUP) {
    __global const float* p = in + HF_PIXEL * element(layout, x0 + i % HF_TILE, y0 - radius + i / HF_TILE);
    float4 sum = taps[0] * vload4(0, p);
    for (int k = 1; k <= radius; ++k) {
      sum = fma((float4)(taps[k]), vload4(0, p - HF_PIXEL * k) + vload4(0, p + HF_PIXEL * k), sum);
    }
    lines[i] = sum;
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  for (int i = (int)get_local_id(0); i < HF_TILE * HF_TILE; i += HF_GROUP) {
    const int x = x0 + i % HF_TILE, y = y0 + i / HF_TILE;
    if (x >= rect.x + rect.width || y >= rect.y + rect.height) continue;
    __local const float4* line = lines + i + radius * HF_TILE;
    float4 sum = taps[0] * line[0];
    for (int k = 1; k <= radius; ++k) sum = fma((float4)(taps[k]), line[-HF_TILE * k] + line[HF_TILE * k], sum);
    vstore4(normalized_pixel(sum), 0, out + HF_PIXEL * element(layout, x, y));
  }
}
#endif
