/* Frames as cameras deliver them -> level 0 of the image: four floats a pixel (three channels in [0, 1], coverage 1).
 */

float3 fetch_bgr8(__global const uchar* frame, hf_frame f, int x, int y) {
  __global const uchar* p = frame + f.offset + y * f.stride + 3 * x;
  return (float3)(p[2], p[1], p[0]);
}

float3 fetch_rgb8(__global const uchar* frame, hf_frame f, int x, int y) {
  __global const uchar* p = frame + f.offset + y * f.stride + 3 * x;
  return (float3)(p[0], p[1], p[2]);
}

float3 fetch_rgba8(__global const uchar* frame, hf_frame f, int x, int y) {
  __global const uchar* p = frame + f.offset + y * f.stride + 4 * x;
  return (float3)(p[0], p[1], p[2]);
}

float3 fetch_bgra8(__global const uchar* frame, hf_frame f, int x, int y) {
  __global const uchar* p = frame + f.offset + y * f.stride + 4 * x;
  return (float3)(p[2], p[1], p[0]);
}

float3 fetch_grey8(__global const uchar* frame, hf_frame f, int x, int y) {
  return (float3)(frame[f.offset + y * f.stride + x], 0.0f, 0.0f);
}

/* BT.601, limited range. */
float3 yuv_to_rgb(float luma, float u, float v) {
  const float y = 1.16438356f * (luma - 16.0f), du = u - 128.0f, dv = v - 128.0f;
  const float3 rgb = (float3)(y + 1.59602678f * dv, y - 0.39176229f * du - 0.81296765f * dv, y + 2.01723214f * du);
  return clamp(rgb, 0.0f, 255.0f);
}

float3 fetch_nv12(__global const uchar* frame, hf_frame f, int x, int y) {
  __global const uchar* chroma = frame + f.offset + (f.height + y / 2) * f.stride + (x & ~1);
  return yuv_to_rgb(frame[f.offset + y * f.stride + x], chroma[0], chroma[1]);
}

float3 fetch_yuyv(__global const uchar* frame, hf_frame f, int x, int y) {
  __global const uchar* pair = frame + f.offset + y * f.stride + 4 * (x / 2);
  return yuv_to_rgb(pair[2 * (x & 1)], pair[1], pair[3]);
}

/* Pixel of the recorded frame that shows pixel (x, y) of the ideal pinhole image: equation 4 of docs/math.md. */
float2 distorted_position(hf_frame f, int x, int y) {
  const float a = (x - f.cx) / f.fx, b = (y - f.cy) / f.fy;
  const float r2 = a * a + b * b;
  if (f.distorted == 2) {
    const float r = sqrt(r2), angle = atan(r), a2 = angle * angle;
    const float bent = angle * (1.0f + a2 * (f.k1 + a2 * (f.k2 + a2 * (f.p1 + a2 * f.p2))));
    const float scale = r > 1e-6f ? bent / r : 1.0f;
    return (float2)(f.fx * a * scale + f.cx, f.fy * b * scale + f.cy);
  }
  const float radial = (1.0f + r2 * (f.k1 + r2 * (f.k2 + r2 * f.k3))) / (1.0f + r2 * (f.k4 + r2 * (f.k5 + r2 * f.k6)));
  const float da = a * radial + 2.0f * f.p1 * a * b + f.p2 * (r2 + 2.0f * a * a);
  const float db = b * radial + f.p1 * (r2 + 2.0f * b * b) + 2.0f * f.p2 * a * b;
  return (float2)(f.fx * da + f.cx, f.fy * db + f.cy);
}

/* What takes a row's pixels several at once starts at column x and returns the column that it got to; `out` is that of
   x. Formats whose pixels are taken one by one stay where they are. */
INLINE int one_by_one(__global const uchar* frame, hf_frame f, int x, int y, int end, __global float* out) { return x; }

/* Formats of BYTES bytes a pixel: four pixels out of the sixteen bytes at p, as long as ENOUGH columns are left, so
   that no byte behind the frame is read. */
#if HF_STRIPS
#define BGR8_PIXELS(p) LOAD_BYTES(p).s210054308760ba90
#define RGB8_PIXELS(p) LOAD_BYTES(p).s0120345067809ab0
#define RGBA8_PIXELS(p) LOAD_BYTES(p)
#define BGRA8_PIXELS(p) LOAD_BYTES(p).s21036547a98bedcf
#define PACKED_PIXELS(NAME, FOUR, BYTES, ENOUGH)                                                           \
  INLINE int NAME(__global const uchar* frame, hf_frame f, int x, int y, int end, __global float* out) {   \
    __global const uchar* p = frame + f.offset + y * f.stride;                                             \
    const float16 all_covered =                                                                            \
        (float16)((float3)(0.0f), 1.0f, (float3)(0.0f), 1.0f, (float3)(0.0f), 1.0f, (float3)(0.0f), 1.0f); \
    const float byte = 1.0f / 255.0f;                                                                      \
    const float16 scale =                                                                                  \
        (float16)((float3)(byte), 0.0f, (float3)(byte), 0.0f, (float3)(byte), 0.0f, (float3)(byte), 0.0f); \
    for (; x + 4 <= end && x + ENOUGH <= f.width; x += 4, out += 16) {                                     \
      STORE(fma(convert_float16(FOUR(p + BYTES * x)), scale, all_covered), out);                           \
    }                                                                                                      \
    return x;                                                                                              \
  }
PACKED_PIXELS(bgr8_pixels, BGR8_PIXELS, 3, 6)
PACKED_PIXELS(rgb8_pixels, RGB8_PIXELS, 3, 6)
PACKED_PIXELS(rgba8_pixels, RGBA8_PIXELS, 4, 4)
PACKED_PIXELS(bgra8_pixels, BGRA8_PIXELS, 4, 4)
#else
#define bgr8_pixels one_by_one
#define rgb8_pixels one_by_one
#define rgba8_pixels one_by_one
#define bgra8_pixels one_by_one
#endif
/* A kernel a format. `rect` of level 0 is written; pixels outside the frame become empty (all zero). */
#define CONVERT_KERNEL(NAME, FETCH, FETCH_PIXELS)                                                                    \
  __kernel void NAME(__global const uchar* frame, hf_frame f, hf_rect rect, hf_layout layout, __global float* out) { \
    const int y = rect.y + (int)get_global_id(1);                                                                    \
    int i = ROW_X_BEGIN;                                                                                             \
    if (!f.distorted && y < f.height) {                                                                              \
      i = FETCH_PIXELS(frame, f, rect.x + i, y, rect.x + ROW_X_END(rect.width),                                      \
                       out + HF_PIXEL * element(layout, rect.x + i, y)) -                                            \
          rect.x;                                                                                                    \
    }                                                                                                                \
    for (; i < ROW_X_END(rect.width); ++i) {                                                                         \
      const int x = rect.x + i;                                                                                      \
      float4 pixel = (float4)(0.0f);                                                                                 \
      if (f.distorted) {                                                                                             \
        const float2 p = distorted_position(f, x, y);                                                                \
        if (p.x >= 0.0f && p.y >= 0.0f && p.x <= f.width - 1.0f && p.y <= f.height - 1.0f && x < f.width &&          \
            y < f.height) {                                                                                          \
          const int x0 = min((int)p.x, max(f.width - 2, 0)), y0 = min((int)p.y, max(f.height - 2, 0));               \
          const int x1 = min(x0 + 1, f.width - 1), y1 = min(y0 + 1, f.height - 1);                                   \
          const float u = p.x - x0, v = p.y - y0;                                                                    \
          const float3 top = FETCH(frame, f, x0, y0) * (1.0f - u) + FETCH(frame, f, x1, y0) * u;                     \
          const float3 bottom = FETCH(frame, f, x0, y1) * (1.0f - u) + FETCH(frame, f, x1, y1) * u;                  \
          pixel = (float4)((top * (1.0f - v) + bottom * v) * (1.0f / 255.0f), 1.0f);                                 \
        }                                                                                                            \
      } else if (x < f.width && y < f.height) {                                                                      \
        pixel = (float4)(FETCH(frame, f, x, y) * (1.0f / 255.0f), 1.0f);                                             \
      }                                                                                                              \
      vstore4(pixel, 0, out + HF_PIXEL * element(layout, x, y));                                                     \
    }                                                                                                                \
  }

CONVERT_KERNEL(convert_bgr8, fetch_bgr8, bgr8_pixels)
CONVERT_KERNEL(convert_rgb8, fetch_rgb8, rgb8_pixels)
CONVERT_KERNEL(convert_rgba8, fetch_rgba8, rgba8_pixels)
CONVERT_KERNEL(convert_grey8, fetch_grey8, one_by_one)
CONVERT_KERNEL(convert_nv12, fetch_nv12, one_by_one)
CONVERT_KERNEL(convert_yuyv, fetch_yuyv, one_by_one)
CONVERT_KERNEL(convert_bgra8, fetch_bgra8, bgra8_pixels)
