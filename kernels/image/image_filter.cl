/* Filters on interleaved pixels (three channels, coverage). Channels of an unfiltered pixel are premultiplied by its
   coverage, so that one linear filter blurs colour and mask together and what is not covered has no weight (equation 6
   of docs/math.md). */

/* The Gaussian of 0.8 pixels that all images are blurred by, along a line: of a pixel and the sums of the two beside
   it, of the two after those and of the last that it reaches, HF_BLUR_RADIUS away. */
INLINE pixel_vector gaussian(pixel_vector here, pixel_vector beside, pixel_vector next, pixel_vector last) {
  const pixel_vector inner = fma((pixel_vector)(0.228310719f), beside, 0.498676449f * here);
  return fma((pixel_vector)(0.000440743373f), last, fma((pixel_vector)(0.0219103135f), next, inner));
}

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

/* Separable Gaussian, then normalisation by coverage, a tile at a time. */
__kernel void blur(__global const float* in, hf_layout layout, hf_rect rect, __global float* out, hf_rect covered) {
  __local float4 lines[(HF_TILE + 2 * HF_BLUR_RADIUS) * HF_TILE];
  const int x0 = rect.x + HF_TILE * (int)get_group_id(0), y0 = rect.y + HF_TILE * (int)get_group_id(1);
  for (int i = (int)get_local_id(0); i < (HF_TILE + 2 * HF_BLUR_RADIUS) * HF_TILE; i += HF_GROUP) {
    const int e = element(layout, x0 + i % HF_TILE, y0 - HF_BLUR_RADIUS + i / HF_TILE);
    lines[i] = gaussian(vload4(e, in), vload4(e - 1, in) + vload4(e + 1, in), vload4(e - 2, in) + vload4(e + 2, in),
                        vload4(e - 3, in) + vload4(e + 3, in));
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  for (int i = (int)get_local_id(0); i < HF_TILE * HF_TILE; i += HF_GROUP) {
    const int x = x0 + i % HF_TILE, y = y0 + i / HF_TILE;
    if (x >= rect.x + rect.width || y >= rect.y + rect.height) continue;
    __local const float4* line = lines + i;
    const float4 sum = gaussian(line[3 * HF_TILE], line[2 * HF_TILE] + line[4 * HF_TILE],
                                line[HF_TILE] + line[5 * HF_TILE], line[0] + line[6 * HF_TILE]);
    vstore4(normalized_pixel(sum), 0, out + HF_PIXEL * element(layout, x, y));
  }
}
#endif
