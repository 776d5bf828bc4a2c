/* The rendered view -> what the constraints compare the frame with: planes of value, gradient, depth and usability. */

/* Packed render -> interleaved pixels (premultiplied by 'known surface') and metric depth, 0 where empty. */
__kernel void unpack_view(__global const uchar* rgba, __global const float* window_depth, hf_view view, hf_rect rect,
                          hf_layout layout, __global float* pixels, __global float* depth) {
  const int row = (int)get_global_id(1);
  for (int i = ROW_X_BEGIN; i < ROW_X_END(rect.width); ++i) {
    const int source = row * view.stride + i;
    const int e = element(layout, rect.x + i, rect.y + row);
    const float d = window_depth[source];
    const float z = view.near_plane * view.far_plane / (view.far_plane - d * (view.far_plane - view.near_plane));
    const uchar4 c = vload4(0, rgba + 4 * source);
    const bool drawn = d < 1.0f;
    float4 pixel = (float4)(0.0f);
    if (drawn && c.w != 0) {
      const float3 rgb = (float3)(c.x, c.y, c.z) * (1.0f / 255.0f);
      pixel = view.grey ? (float4)(0.299f * rgb.x + 0.587f * rgb.y + 0.114f * rgb.z, 0.0f, 0.0f, 1.0f)
                        : (float4)(rgb, 1.0f);
    }
    vstore4(pixel, 0, pixels + HF_PIXEL * e);
    depth[e] = drawn ? z : 0.0f;
  }
}

/* Depth of the coarser level: the mean of those of the 2x2 pixels that are drawn. */
__kernel void halve_depth(__global const float* in, hf_layout in_layout, hf_rect rect, hf_layout out_layout,
                          __global float* out) {
  const int y = rect.y + (int)get_global_id(1);
  for (int i = ROW_X_BEGIN; i < ROW_X_END(rect.width); ++i) {
    const int x = rect.x + i;
    __global const float* p = in + element(in_layout, 2 * x, 2 * y);
    const float4 z = (float4)(p[0], p[1], p[in_layout.stride], p[in_layout.stride + 1]);
    const float count = dot((float4)(1.0f), select((float4)(0.0f), (float4)(1.0f), z > 0.0f));
    out[element(out_layout, x, y)] = count > 0.0f ? (z.x + z.y + z.z + z.w) / count : 0.0f;
  }
}

bool depth_jump(float z, float other, float relative) { return other <= 0.0f || fabs(other - z) > relative * z; }

/* Blurred, normalised pixels -> planes. Usable: covered at least `least_coverage` within the blur's reach and no depth
   jump among the neighbours; `usable` is 0 outside the object, HF_UNUSABLE or HF_USED. */
__kernel void template_planes(__global const float* in, __global const float* depth, hf_layout layout, hf_rect rect,
                              float least_coverage, float jump, __global float* value, __global float* dx,
                              __global float* dy, int plane, __global uchar* usable) {
  const int y = rect.y + (int)get_global_id(1);
  for (int i = ROW_X_BEGIN; i < ROW_X_END(rect.width); ++i) {
    const int e = element(layout, rect.x + i, y);
    const float z = depth[e];
    uchar state = HF_NOT_VISIBLE;
    float4 v = (float4)(0.0f), gx = (float4)(0.0f), gy = (float4)(0.0f);
    if (z > 0.0f) {
      __global const float* p = in + HF_PIXEL * e;
      const int step = HF_PIXEL * layout.stride;
      v = vload4(0, p);
      const float4 left = vload4(0, p - HF_PIXEL), right = vload4(0, p + HF_PIXEL);
      const float4 up = vload4(0, p - step), down = vload4(0, p + step);
      gx = 0.5f * (right - left);
      gy = 0.5f * (down - up);
      const bool covered = v.w >= least_coverage && left.w > 0.25f && right.w > 0.25f && up.w > 0.25f && down.w > 0.25f;
      const bool smooth = !depth_jump(z, depth[e - 1], jump) && !depth_jump(z, depth[e + 1], jump) &&
                          !depth_jump(z, depth[e - layout.stride], jump) &&
                          !depth_jump(z, depth[e + layout.stride], jump);
      state = covered && smooth ? HF_USED : HF_UNUSABLE;
    }
    value[e] = v.x;
    value[e + plane] = v.y;
    value[e + 2 * plane] = v.z;
    dx[e] = gx.x;
    dx[e + plane] = gx.y;
    dx[e + 2 * plane] = gx.z;
    dy[e] = gy.x;
    dy[e + plane] = gy.y;
    dy[e + 2 * plane] = gy.z;
    usable[e] = state;
  }
}
