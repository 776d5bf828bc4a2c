/* Edges of the frame across the edges of a model: a work-item a line, whatever the partition (equations 32 to 34 of
   docs/math.md). */

/* Colour of the frame between pixels; w: 1 where all four pixels hold the frame. */
INLINE float4 color_between(__global const float* frame, hf_layout layout, hf_rect region, float2 at) {
  const float2 corner = floor(at);
  const int x = (int)corner.x, y = (int)corner.y;
  if (!(x >= region.x && y >= region.y && x + 1 < region.x + region.width && y + 1 < region.y + region.height))
    return (float4)(0.0f);
  const float2 share = at - corner;
  const float4 a = vload4(element(layout, x, y), frame), b = vload4(element(layout, x + 1, y), frame);
  const float4 c = vload4(element(layout, x, y + 1), frame), d = vload4(element(layout, x + 1, y + 1), frame);
  return mix(mix(a, b, share.x), mix(c, d, share.x), share.y);
}

/* Each line's most telling edges: places where the step of colour along the normal is largest, weighed by how much it
   stands out along the line and how like the usual one it is. */
__kernel void edge_candidates(__global const float* frame, hf_layout layout, __global const float* lines, hf_edges o,
                              __global float* candidates) {
  const int i = (int)get_global_id(0);
  if (i >= o.count) return;
  __global float* out = candidates + i * HF_EDGE_CANDIDATES * HF_EDGE_CANDIDATE;
  for (int n = 0; n < HF_EDGE_CANDIDATES * HF_EDGE_CANDIDATE; ++n) out[n] = 0.0f;
  const float8 line = vload8(i, lines);
  const float2 normal = line.s23, along = (float2)(-normal.y, normal.x);
  const float3 usual = line.s456;

  /* step[k + 1]: of colour from k - 1 to k + 1 along the normal, for k = -reach - 1 to reach + 1. */
  float4 step[2 * HF_EDGE_REACH + 3], before = (float4)(0.0f), here = (float4)(0.0f);
  float square[2 * HF_EDGE_REACH + 3];
  float sum = 0.0f, count = 0.0f;
  for (int k = -HF_EDGE_REACH - 2; k <= HF_EDGE_REACH + 2; ++k) {
    const float2 at = line.s01 + (float)k * normal;
    const float4 next = 0.25f * (color_between(frame, layout, o.region, at - along) +
                                 color_between(frame, layout, o.region, at + along)) +
                        0.5f * color_between(frame, layout, o.region, at);
    const int n = k + HF_EDGE_REACH;
    if (n >= 0) {
      const int whole = fmin(fmin(before.w, here.w), next.w) > 0.99f;
      step[n] = whole ? next - before : (float4)(0.0f);
      square[n] = whole ? dot(step[n].xyz, step[n].xyz) : 0.0f;
      if (whole) {
        sum += square[n];
        count += 1.0f;
      }
    }
    before = here;
    here = next;
  }
  if (count < HF_EDGE_REACH) return;
  const float ordinary = sum / count + HF_EDGE_NOISE2;
  for (int n = 1; n < 2 * HF_EDGE_REACH + 2; ++n) {
    if (!(square[n] >= square[n - 1] && square[n] > square[n + 1] && square[n] > HF_EDGE_NOISE2)) continue;
    float weight = square[n] / (square[n] + ordinary);
    if (line.s7 > 0.0f)
      weight *= fmax(HF_EDGE_UNLIKE, 2.0f * dot(step[n].xyz, usual) / (square[n] + dot(usual, usual) + 1e-12f));
    /* The place of the largest step, by the parabola through its neighbours. */
    const float a = sqrt(square[n - 1]), b = sqrt(square[n]), c = sqrt(square[n + 1]);
    const float bend = a - 2.0f * b + c;
    const float place = bend < -1e-9f ? clamp(0.5f * (a - c) / bend, -0.5f, 0.5f) : 0.0f;
    /* Kept in order of weight. */
    for (int slot = 0; slot < HF_EDGE_CANDIDATES; ++slot) {
      if (!(weight > out[slot * HF_EDGE_CANDIDATE + 1])) continue;
      for (int m = (HF_EDGE_CANDIDATES - 1) * HF_EDGE_CANDIDATE - 1; m >= slot * HF_EDGE_CANDIDATE; --m)
        out[m + HF_EDGE_CANDIDATE] = out[m];
      out[slot * HF_EDGE_CANDIDATE] = (float)(n - 1 - HF_EDGE_REACH) + place;
      out[slot * HF_EDGE_CANDIDATE + 1] = weight;
      out[slot * HF_EDGE_CANDIDATE + 2] = step[n].x;
      out[slot * HF_EDGE_CANDIDATE + 3] = step[n].y;
      out[slot * HF_EDGE_CANDIDATE + 4] = step[n].z;
      break;
    }
  }
}
