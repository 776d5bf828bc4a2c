/* How well the frame's gradients agree with the rendered view's when the view is shifted by whole pixels: one score a
   shift, bounded a pixel, so that neither light nor partial occlusion decides (equation 14 of docs/math.md). */
__kernel void shift_scores(__global const float* dx, __global const float* dy, int plane, __global const uchar* usable,
                           hf_layout layout, hf_rect rect, int step, __global const float* features, int4 sampled,
                           int first_x, int first_y, __global float* scores) {
  const int shift_x = first_x + (int)get_global_id(0), shift_y = first_y + (int)get_global_id(1);
  float agreement = 0.0f, weight = 0.0f;
  for (int y = rect.y; y < rect.y + rect.height; y += step) {
    for (int x = rect.x; x < rect.x + rect.width; x += step) {
      const int e = element(layout, x, y);
      if (usable[e] != HF_USED) continue;
      const float4 vx = (float4)(dx[e], dx[e + plane], dx[e + 2 * plane], 0.0f);
      const float4 vy = (float4)(dy[e], dy[e + plane], dy[e + 2 * plane], 0.0f);
      const float mv2 = dot(vx, vx) + dot(vy, vy);
      if (mv2 < 1e-5f) continue;
      const float mv = sqrt(mv2);
      weight += mv;
      const int u = x + shift_x, v = y + shift_y;
      if (u < sampled.x || v < sampled.y || u > sampled.z || v > sampled.w) continue;
      __global const float* p = features + HF_FEATURE * element(layout, u, v);
      float4 ix = vload4(0, p + 3), iy = vload4(0, p + 6);
      ix.w = iy.w = 0.0f;
      const float mi2 = dot(ix, ix) + dot(iy, iy);
      agreement += mv * (dot(vx, ix) + dot(vy, iy)) / (0.5f * (mv2 + mi2) + 1e-5f);
    }
  }
  scores[(int)get_global_id(1) * (int)get_global_size(0) + (int)get_global_id(0)] =
      weight > 0.0f ? agreement / weight : 0.0f;
}
