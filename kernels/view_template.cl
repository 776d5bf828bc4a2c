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

#if HF_STRIPS
typedef float4 pixel_lane; /* one number of each of the pixels taken at once */
typedef int4 pixel_mask;
#define CHANNEL_0(v) (v).s048c
#define CHANNEL_1(v) (v).s159d
#define CHANNEL_2(v) (v).s26ae
#define CHANNEL_3(v) (v).s37bf
#define LOAD_LANE(p) vload4(0, (p))
#define STORE_LANE(v, p) vstore4((v), 0, (p))
#define PIXEL_INDEX ((int4)(0, 1, 2, 3))
#define STORE_STATE(v, p) vstore4(convert_uchar4(v), 0, (p))
#define NO_PIXEL(mask) (!any(mask))
#else
typedef float pixel_lane;
typedef int pixel_mask;
#define CHANNEL_0(v) (v).x
#define CHANNEL_1(v) (v).y
#define CHANNEL_2(v) (v).z
#define CHANNEL_3(v) (v).w
#define LOAD_LANE(p) (*(p))
#define STORE_LANE(v, p) (*(p) = (v))
#define PIXEL_INDEX 0
#define STORE_STATE(v, p) (*(p) = (uchar)(v))
#define NO_PIXEL(mask) (!(mask))
#endif

pixel_mask depth_jump(pixel_lane z, pixel_lane other, float relative) {
  return (other <= 0.0f) | (fabs(other - z) > relative * z);
}

/* Blurred, normalised pixels -> planes. Usable: covered at least `least_coverage` within the blur's reach and no depth
   jump or hole within `reach` pixels in the row and the column; `usable` is 0 outside the object (and outside the
   frame of width x height), HF_UNUSABLE or HF_USED. The planes are written where the object is. */
__kernel void template_planes(__global const float* in, __global const float* depth, hf_layout layout, hf_rect rect,
                              int width, int height, float least_coverage, float jump, int reach,
                              __global float* value, __global float* dx, __global float* dy, int plane,
                              __global uchar* usable) {
  const int y = rect.y + (int)get_global_id(1);
  for (int i = ROW_X_BEGIN; i < ROW_X_END(rect.width); i += PIXELS_AT_ONCE) {
    const int e = element(layout, rect.x + i, y);
    const pixel_lane z = LOAD_LANE(depth + e);
    const pixel_mask visible = (z > 0.0f) & ((pixel_mask)(rect.x + i) + PIXEL_INDEX < width) & (y < height ? ~0 : 0);
    if (NO_PIXEL(visible)) {
      STORE_STATE((pixel_mask)(HF_NOT_VISIBLE), usable + e);
      continue;
    }
    __global const float* p = in + HF_PIXEL * e;
    const int step = HF_PIXEL * layout.stride;
    const pixel_vector v = LOAD_PIXELS(p), left = LOAD_PIXELS(p - HF_PIXEL), right = LOAD_PIXELS(p + HF_PIXEL);
    const pixel_vector up = LOAD_PIXELS(p - step), down = LOAD_PIXELS(p + step);
    const pixel_vector gx = 0.5f * (right - left), gy = 0.5f * (down - up);
    pixel_mask good = (CHANNEL_3(v) >= least_coverage) & (CHANNEL_3(left) > 0.25f) & (CHANNEL_3(right) > 0.25f) &
                      (CHANNEL_3(up) > 0.25f) & (CHANNEL_3(down) > 0.25f);
    for (int k = 1; k <= reach; ++k) {
      const pixel_mask broken = depth_jump(z, LOAD_LANE(depth + e - k), jump) |
                                depth_jump(z, LOAD_LANE(depth + e + k), jump) |
                                depth_jump(z, LOAD_LANE(depth + e - k * layout.stride), jump) |
                                depth_jump(z, LOAD_LANE(depth + e + k * layout.stride), jump);
      good &= !broken;
    }
    pixel_mask state = CHOOSE((pixel_mask)(HF_UNUSABLE), (pixel_mask)(HF_USED), good);
    state = CHOOSE((pixel_mask)(HF_NOT_VISIBLE), state, visible);
    STORE_STATE(state, usable + e);
    STORE_LANE(CHANNEL_0(v), value + e);
    STORE_LANE(CHANNEL_1(v), value + e + plane);
    STORE_LANE(CHANNEL_2(v), value + e + 2 * plane);
    STORE_LANE(CHANNEL_0(gx), dx + e);
    STORE_LANE(CHANNEL_1(gx), dx + e + plane);
    STORE_LANE(CHANNEL_2(gx), dx + e + 2 * plane);
    STORE_LANE(CHANNEL_0(gy), dy + e);
    STORE_LANE(CHANNEL_1(gy), dy + e + plane);
    STORE_LANE(CHANNEL_2(gy), dy + e + 2 * plane);
  }
}
