/* The rendered view -> what the constraints compare the frame with: planes of value, gradient, depth and usability. */

/* Packed render -> interleaved pixels (premultiplied by 'known surface') and metric depth, 0 where empty. */
__kernel void unpack_view(__global const uchar* rgba, __global const float* window_depth, hf_view view, hf_rect rect,
                          hf_layout layout, __global float* pixels, __global float* depth) {
  const int row = (int)get_global_id(1);
  for (int i = ROW_X_BEGIN; i < ROW_X_END(rect.width); i += PIXELS_AT_ONCE) {
    const int source = row * view.stride + i;
    const int e = element(layout, rect.x + i, rect.y + row);
    const pixel_lane d = LOAD_LANE(window_depth + source);
    const pixel_lane z = view.near_plane * view.far_plane / (view.far_plane - d * (view.far_plane - view.near_plane));
    const pixel_mask drawn = d < 1.0f;
    STORE_LANE(CHOOSE((pixel_lane)(0.0f), z, drawn), depth + e);
    const pixel_vector bytes = CONVERT_PIXELS(LOAD_PIXEL_BYTES(rgba + 4 * source));
    const pixel_lane known = CHOOSE((pixel_lane)(0.0f), (pixel_lane)(1.0f), drawn & (CHANNEL_3(bytes) > 0.0f));
    pixel_lane red = CHANNEL_0(bytes) * known * (1.0f / 255.0f), green = CHANNEL_1(bytes) * known * (1.0f / 255.0f);
    pixel_lane blue = CHANNEL_2(bytes) * known * (1.0f / 255.0f);
    if (view.grey) {
      red = 0.299f * red + 0.587f * green + 0.114f * blue;
      green = blue = (pixel_lane)(0.0f);
    }
    STORE_PIXELS(INTERLEAVED(red, green, blue, known), pixels + HF_PIXEL * e);
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

lane_int depth_jump(lane_float z, lane_float other, float relative) {
  return (other <= 0.0f) | (fabs(other - z) > relative * z);
}

/* 1/Z is linear in the image on a plane: whether it bends between two pixels `step` elements either way. */
INLINE lane_int bent(__global const float* depth, int step, float relative) {
  const lane_float z = LOAD(depth), before = LOAD(depth - step), after = LOAD(depth + step);
  return (before > 0.0f) & (after > 0.0f) & (fabs(z / before + z / after - 2.0f) > relative);
}

/* Interleaved pixels side by side. `around`: the least coverage of a pixel's four neighbours. */
typedef struct {
  lane_float value[HF_CHANNELS], dx[HF_CHANNELS], dy[HF_CHANNELS], coverage, around;
} view_pixels;

INLINE void load_view_pixels(__global const float* p, int step, view_pixels* pixels) {
#if HF_STRIPS
  const float16 a = LOAD(p), b = LOAD(p + 16), c = LOAD(p + 32), d = LOAD(p + 48);
  TRANSPOSE(a, b, c, d, pixels->value)
  pixels->coverage = COLUMN(a, b, c, d, s37bf);
#define NEIGHBOURS(x, i)                                                                     \
  const float16 left_##x = LOAD(p + (i)-HF_PIXEL), right_##x = LOAD(p + (i) + HF_PIXEL);     \
  const float16 up_##x = LOAD(p + (i)-step), down_##x = LOAD(p + (i) + step);                \
  const float16 dx_##x = 0.5f * (right_##x - left_##x), dy_##x = 0.5f * (down_##x - up_##x); \
  const float16 least_##x = fmin(fmin(left_##x, right_##x), fmin(up_##x, down_##x));
  NEIGHBOURS(a, 0)
  NEIGHBOURS(b, 16)
  NEIGHBOURS(c, 32)
  NEIGHBOURS(d, 48)
#undef NEIGHBOURS
  TRANSPOSE(dx_a, dx_b, dx_c, dx_d, pixels->dx)
  TRANSPOSE(dy_a, dy_b, dy_c, dy_d, pixels->dy)
  pixels->around = COLUMN(least_a, least_b, least_c, least_d, s37bf);
#else
  const float4 v = vload4(0, p), left = vload4(0, p - HF_PIXEL), right = vload4(0, p + HF_PIXEL);
  const float4 up = vload4(0, p - step), down = vload4(0, p + step);
  const float4 dx = 0.5f * (right - left), dy = 0.5f * (down - up);
  pixels->value[0] = v.x;
  pixels->value[1] = v.y;
  pixels->value[2] = v.z;
  pixels->coverage = v.w;
  pixels->dx[0] = dx.x;
  pixels->dx[1] = dx.y;
  pixels->dx[2] = dx.z;
  pixels->dy[0] = dy.x;
  pixels->dy[1] = dy.y;
  pixels->dy[2] = dy.z;
  pixels->around = fmin(fmin(left.w, right.w), fmin(up.w, down.w));
#endif
}

/* Blurred, normalised pixels -> planes. Usable: covered at least `least_coverage` within the blur's reach and no depth
   jump or hole within `reach` pixels in the row and the column, nor, where `bend` is above 0, an edge between faces
   within three; `usable` is 0 outside the object (and outside the frame of width x height), HF_UNUSABLE or HF_USED. The
   planes are written where the object is. */
__kernel void template_planes(__global const float* in, __global const float* depth, hf_layout layout, hf_rect rect,
                              int width, int height, float least_coverage, float jump, int reach, __global float* value,
                              __global float* dx, __global float* dy, int plane, __global uchar* usable, float bend) {
  const int y = rect.y + (int)get_global_id(1);
  for (int i = ROW_X_BEGIN; i < ROW_X_END(rect.width); i += LANES) {
    const int x = rect.x + i, e = element(layout, x, y);
    const lane_float z = LOAD(depth + e);
    const lane_int visible = (z > 0.0f) & ((lane_float)(x) + LANE_INDEX < (lane_float)(width)) & (y < height ? ~0 : 0);
    if (!ANY(visible)) {
      STORE_BYTES((lane_uchar)(HF_NOT_VISIBLE), usable + e);
      continue;
    }
    view_pixels pixels;
    load_view_pixels(in + HF_PIXEL * e, HF_PIXEL * layout.stride, &pixels);
    lane_int good = (pixels.coverage >= least_coverage) & (pixels.around > 0.25f);
    for (int k = 1; k <= reach; ++k) {
      const lane_int broken = depth_jump(z, LOAD(depth + e - k), jump) | depth_jump(z, LOAD(depth + e + k), jump) |
                              depth_jump(z, LOAD(depth + e - k * layout.stride), jump) |
                              depth_jump(z, LOAD(depth + e + k * layout.stride), jump);
      good &= broken == 0;
    }
    if (bend > 0.0f) {
      const lane_int edge = bent(depth + e, 1, bend) | bent(depth + e, 3, bend) | bent(depth + e, layout.stride, bend) |
                            bent(depth + e, 3 * layout.stride, bend);
      good &= edge == 0;
    }
    lane_int state = CHOOSE((lane_int)(HF_UNUSABLE), (lane_int)(HF_USED), good);
    state = CHOOSE((lane_int)(HF_NOT_VISIBLE), state, visible);
    STORE_BYTES(TO_UCHAR(state), usable + e);
#pragma unroll
    for (int c = 0; c < HF_CHANNELS; ++c) {
      STORE(pixels.value[c], value + e + c * plane);
      STORE(pixels.dx[c], dx + e + c * plane);
      STORE(pixels.dy[c], dy + e + c * plane);
    }
  }
}
