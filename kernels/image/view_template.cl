/* The rendered view -> what the constraints compare the frame with: planes of value, gradient, depth and usability. */

/* Window depth -> metric depth, 0 where nothing is drawn. */
INLINE pixel_lane metric_depth(pixel_lane d, hf_view view) {
  const pixel_lane z = view.near_plane * view.far_plane / (view.far_plane - d * (view.far_plane - view.near_plane));
  return select((pixel_lane)(0.0f), z, d < 1.0f);
}

__kernel void unpack_depth(__global const float* window_depth, hf_view view, hf_rect rect, hf_layout layout,
                           __global float* depth) {
  const int row = (int)get_global_id(1);
  for (int i = ROW_X_BEGIN; i < ROW_X_END(rect.width); i += PIXELS_AT_ONCE) {
    const pixel_lane d = LOAD_LANE(window_depth + row * view.stride + i);
    STORE_LANE(metric_depth(d, view), depth + element(layout, rect.x + i, rect.y + row));
  }
}

/* Packed render -> interleaved pixels (premultiplied by 'known surface') and metric depth. */
__kernel void unpack_view(__global const uchar* rgba, __global const float* window_depth, hf_view view, hf_rect rect,
                          hf_layout layout, __global float* pixels, __global float* depth) {
  const int row = (int)get_global_id(1);
  for (int i = ROW_X_BEGIN; i < ROW_X_END(rect.width); i += PIXELS_AT_ONCE) {
    const int source = row * view.stride + i;
    const int e = element(layout, rect.x + i, rect.y + row);
    const pixel_lane d = LOAD_LANE(window_depth + source);
    STORE_LANE(metric_depth(d, view), depth + e);
    const pixel_vector bytes = CONVERT_PIXELS(LOAD_PIXEL_BYTES(rgba + 4 * (HF_RENDER_GUARD + source)));
    const pixel_lane known = select((pixel_lane)(0.0f), (pixel_lane)(1.0f), (d < 1.0f) & (CHANNEL_3(bytes) > 0.0f));
    pixel_lane red = CHANNEL_0(bytes) * known * (1.0f / 255.0f), green = CHANNEL_1(bytes) * known * (1.0f / 255.0f);
    pixel_lane blue = CHANNEL_2(bytes) * known * (1.0f / 255.0f);
    if (view.grey) {
      red = LUMA(red, green, blue);
      green = blue = (pixel_lane)(0.0f);
    }
    STORE_PIXELS(INTERLEAVED(red, green, blue, known), pixels + HF_PIXEL * e);
  }
}

/* The frame's own pixels where the object is drawn, as if they were its render. */
__kernel void unpack_snapshot(__global const float* frame, __global const float* window_depth, hf_view view,
                              hf_rect rect, hf_rect uploaded, hf_layout layout, __global float* pixels,
                              __global float* depth) {
  const int row = (int)get_global_id(1), y = rect.y + row;
  for (int i = ROW_X_BEGIN; i < ROW_X_END(rect.width); ++i) {
    const int x = rect.x + i, e = element(layout, x, y);
    const float d = window_depth[row * view.stride + i];
    const float z = view.near_plane * view.far_plane / (view.far_plane - d * (view.far_plane - view.near_plane));
    const int inside =
        x >= uploaded.x && y >= uploaded.y && x < uploaded.x + uploaded.width && y < uploaded.y + uploaded.height;
    float4 pixel = (float4)(0.0f);
    if (d < 1.0f && inside) pixel = vload4(e, frame);
    if (pixel.w < HF_LEAST_COVERAGE) pixel = (float4)(0.0f);
    vstore4(pixel, e, pixels);
    depth[e] = d < 1.0f ? z : 0.0f;
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

/* Blurred, normalised pixels side by side. `around`: the least coverage of a pixel's four neighbours. */
typedef struct {
  lane_float value[HF_CHANNELS], dx[HF_CHANNELS], dy[HF_CHANNELS], coverage, around;
} view_pixels;

INLINE lane_int visible_pixels(lane_float z, int x, int y, hf_template k) {
  return (z > 0.0f) & ((lane_float)(x) + LANE_INDEX < (lane_float)(k.width)) & (y < k.height ? ~0 : 0);
}

/* Usable: covered at least `least_coverage` within the blur's reach and no depth jump or hole within `reach` pixels in
   the row and the column, nor, where `bend` is above 0, an edge between faces within three; `usable` is 0 outside the
   object (and outside the frame of width x height), HF_UNUSABLE or HF_USED. */
INLINE void store_planes(const view_pixels* pixels, lane_float z, lane_int visible, __global const float* depth,
                         hf_layout layout, int e, hf_template k, __global float* value, __global float* dx,
                         __global float* dy, __global uchar* usable) {
  lane_int good = (pixels->coverage >= k.least_coverage) & (pixels->around > 0.25f);
  for (int i = 1; i <= k.reach; ++i) {
    const lane_int broken = depth_jump(z, LOAD(depth + e - i), k.jump) | depth_jump(z, LOAD(depth + e + i), k.jump) |
                            depth_jump(z, LOAD(depth + e - i * layout.stride), k.jump) |
                            depth_jump(z, LOAD(depth + e + i * layout.stride), k.jump);
    good &= broken == 0;
  }
  if (k.bend > 0.0f) {
    const lane_int edge = bent(depth + e, 1, k.bend) | bent(depth + e, 3, k.bend) |
                          bent(depth + e, layout.stride, k.bend) | bent(depth + e, 3 * layout.stride, k.bend);
    good &= edge == 0;
  }
  lane_int state = select((lane_int)(HF_UNUSABLE), (lane_int)(HF_USED), good);
  state = select((lane_int)(HF_NOT_VISIBLE), state, visible);
  STORE_BYTES(TO_UCHAR(state), usable + e);
#pragma unroll
  for (int c = 0; c < HF_CHANNELS; ++c) {
    STORE(pixels->value[c], value + e + c * k.plane);
    STORE(pixels->dx[c], dx + e + c * k.plane);
    STORE(pixels->dy[c], dy + e + c * k.plane);
  }
}

#if HF_STRIPS
/* Sixteen packed pixels of the render from column x on; outside of the row's `width` there are none. */
INLINE uint16 rendered_pixels(__global const uint* row, int width, int x) {
  if (width == 0) return (uint16)(0);
  const uint16 pixels = as_uint16(LOAD((__global const float*)(row + x)));
  if (x >= 0 && x + 16 <= width) return pixels;
  const float16 column = (float)x + LANE_INDEX;
  return select((uint16)(0), pixels, (column >= 0.0f) & (column < (float)width));
}

/* What alpha says is unknown is empty, whatever its colour. */
INLINE void take_view_apart(uint16 pixels, int grey, float16* line) {
  const uint16 alpha = pixels & 0xff000000u;
  take_bytes_apart(select((uint16)(0), pixels | 0xff000000u, alpha != 0u), 4, line);
  if (grey) {
    line[0] = LUMA(line[0], line[LINE_VECTORS], line[2 * LINE_VECTORS]);
    line[LINE_VECTORS] = line[2 * LINE_VECTORS] = (float16)(0.0f);
  }
}

/* Blurred rows that are kept: three for the differences, and one that was stored just now and would be waited for. */
#define KEPT_ROWS 4

/* Row y of a block that starts at the pixel before the row's first, blurred and normalised, a plane a channel. */
INLINE void keep_row(const float16* ring, int y, int vectors, float16* row) {
  const float16* rows[RING_ROWS];
  rows_around(ring, y, rows);
  for (int v = 0; v < vectors; ++v) {
    const float16 coverage = sum_across(rows, 3 * ROW_VECTORS + v);
    row[3 * ROW_VECTORS + v] = coverage;
    const float16 inverse = inverse_of_coverage(coverage);
#pragma unroll
    for (int c = 0; c < HF_CHANNELS; ++c) {
      row[c * ROW_VECTORS + v] = inverse * sum_across(rows, c * ROW_VECTORS + v);
    }
  }
}

INLINE void planes_of_row(const float16* above, const float16* here, const float16* below, __global const float* depth,
                          hf_layout layout, hf_rect rect, hf_rect block, int y, hf_template k, __global float* value,
                          __global float* dx, __global float* dy, __global uchar* usable) {
  const int row_inside = y > rect.y && y < rect.y + rect.height - 1 ? ~0 : 0;
  for (int v = 0; 16 * v < block.width; ++v) {
    const int x = block.x + 16 * v, e = element(layout, x, y);
    const float16 z = LOAD(depth + e);
    const int16 visible = visible_pixels(z, x, y, k);
    if (!any(visible)) continue;
    view_pixels pixels;
    const float *left = (const float*)(here + v), *up = (const float*)(above + v) + 1;
    const float* down = (const float*)(below + v) + 1;
#pragma unroll
    for (int c = 0; c < HF_CHANNELS; ++c) {
      const int i = 16 * c * ROW_VECTORS;
      pixels.value[c] = LOAD_PRIVATE(left + i + 1);
      pixels.dx[c] = 0.5f * (LOAD_PRIVATE(left + i + 2) - LOAD_PRIVATE(left + i));
      pixels.dy[c] = 0.5f * (LOAD_PRIVATE(down + i) - LOAD_PRIVATE(up + i));
    }
    const int i = 16 * 3 * ROW_VECTORS;
    pixels.coverage = LOAD_PRIVATE(left + i + 1);
    pixels.around = fmin(fmin(LOAD_PRIVATE(left + i), LOAD_PRIVATE(left + i + 2)),
                         fmin(LOAD_PRIVATE(up + i), LOAD_PRIVATE(down + i)));
    /* What lies outside of `rect` is not covered. */
    const float16 column = (float)x + LANE_INDEX;
    const int16 inside = (column > (float)rect.x) & (column < (float)(rect.x + rect.width - 1)) & row_inside;
    pixels.around = select((float16)(0.0f), pixels.around, inside);
    store_planes(&pixels, z, visible, depth, layout, e, k, value, dx, dy, usable);
  }
}

/* The part of a block, in whole vectors, that has visible pixels; vectors without any are marked so. */
INLINE hf_rect visible_part(__global const float* depth, hf_layout layout, hf_rect block, hf_template k,
                            __global uchar* usable) {
  int left = block.width, right = 0, top = block.height, bottom = 0;
  for (int y = 0; y < block.height; ++y) {
    for (int x = 0; x < block.width; x += 16) {
      const int e = element(layout, block.x + x, block.y + y);
      if (!any(visible_pixels(LOAD(depth + e), block.x + x, block.y + y, k))) {
        STORE_BYTES((uchar16)(HF_NOT_VISIBLE), usable + e);
        continue;
      }
      left = min(left, x);
      right = max(right, x + 16);
      top = min(top, y);
      bottom = y + 1;
    }
  }
  hf_rect part;
  part.x = block.x + left;
  part.y = block.y + top;
  part.width = max(0, right - left);
  part.height = max(0, bottom - top);
  return part;
}

/* The visible part of the item's block of `rect`: interleaved pixels or, where the view has a stride, its packed render
   as it comes, and depth -> blurred, normalised planes and their differences. They are written where the object is. */
__kernel void template_planes(__global const float* in, hf_view view, __global const float* depth, hf_layout layout,
                              hf_rect rect, hf_template k, __global float* value, __global float* dx,
                              __global float* dy, __global uchar* usable) {
  const hf_rect block = visible_part(depth, layout, block_of(rect), k, usable);
  if (block.width == 0) return;
  float16 line_pair[2 * LINE], ring[RING_ROWS * ROW], kept[KEPT_ROWS * ROW];
  const int vectors = block.width / 16 + 1, lines = (block.width + RING_ROWS + 16) / 16;
  const int count = block.height + RING_ROWS + 1, x = block.x - 1 - HF_BLUR_RADIUS;
  for (int i = 0; i <= count + 1; ++i) {
    if (i < count) {
      const int y = block.y - 1 - HF_BLUR_RADIUS + i;
      float16* line = line_pair + i % 2 * LINE;
      const int width = y >= rect.y && y < rect.y + rect.height ? rect.width : 0;
      __global const uint* packed = (__global const uint*)in + HF_RENDER_GUARD + (y - rect.y) * view.stride;
      for (int v = 0; v < lines; ++v) {
        if (view.stride == 0) {
          take_apart(in + HF_PIXEL * element(layout, x + 16 * v, y), 4, line + v);
        } else {
          take_view_apart(rendered_pixels(packed, width, x - rect.x + 16 * v), view.grey, line + v);
        }
      }
    }
    if (i > 0 && i <= count) sum_along(line_pair + (i - 1) % 2 * LINE, 4, vectors, ring + (i - 1) % RING_ROWS * ROW);
    const int row = i - RING_ROWS;
    if (row >= 0 && row < block.height + 2) keep_row(ring, row, vectors, kept + row % KEPT_ROWS * ROW);
    if (row < 3) continue;
    planes_of_row(kept + (row - 3) % KEPT_ROWS * ROW, kept + (row - 2) % KEPT_ROWS * ROW,
                  kept + (row - 1) % KEPT_ROWS * ROW, depth, layout, rect, block, block.y + row - 3, k, value, dx, dy,
                  usable);
  }
}
#else
/* Blurred, normalised pixels -> planes. They are written where the object is. */
__kernel void template_planes(__global const float* in, hf_view view, __global const float* depth, hf_layout layout,
                              hf_rect rect, hf_template k, __global float* value, __global float* dx,
                              __global float* dy, __global uchar* usable) {
  const int i = (int)get_global_id(0), x = rect.x + i, y = rect.y + (int)get_global_id(1);
  if (i >= rect.width) return;
  const int e = element(layout, x, y), step = HF_PIXEL * layout.stride;
  const float z = depth[e];
  const int visible = visible_pixels(z, x, y, k);
  if (!visible) {
    usable[e] = HF_NOT_VISIBLE;
    return;
  }
  __global const float* p = in + HF_PIXEL * e;
  const float4 v = vload4(0, p), left = vload4(0, p - HF_PIXEL), right = vload4(0, p + HF_PIXEL);
  const float4 up = vload4(0, p - step), down = vload4(0, p + step);
  view_pixels pixels;
  pixels.coverage = v.w;
  vstore3(v.xyz, 0, pixels.value);
  vstore3(0.5f * (right - left).xyz, 0, pixels.dx);
  vstore3(0.5f * (down - up).xyz, 0, pixels.dy);
  pixels.around = fmin(fmin(left.w, right.w), fmin(up.w, down.w));
  store_planes(&pixels, z, visible, depth, layout, e, k, value, dx, dy, usable);
}
#endif
