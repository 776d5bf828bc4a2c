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

#if !HF_STRIPS
/* Channels divided by coverage; coverage kept. */
float4 normalized_pixel(float4 p) { return (float4)(p.xyz * (p.w > 1e-4f ? 1.0f / p.w : 0.0f), p.w); }

/* Separable Gaussian, then normalisation by coverage, a tile at a time. taps[0] is the centre's. */
__kernel void blur(__global const float* in, hf_layout layout, hf_rect rect, __constant float* taps, int radius,
                   __global float* out, hf_rect covered) {
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
