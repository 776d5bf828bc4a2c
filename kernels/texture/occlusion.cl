/* Samples the frame where each rendered pixel lies now and compares gradients: equations 5 and 7 to 10 of
   docs/math.md. */

/* Value and gradient (central differences) of three channels, and coverage. */
typedef struct {
  lane_float value[HF_CHANNELS], dx[HF_CHANNELS], dy[HF_CHANNELS], coverage;
} frame_samples;

typedef struct {
  float4 value, dx, dy;
} pixel_sample;

/* Bilinear between the four pixels around p[0] and p[HF_PIXEL], at (u, v) from p[0]: first between rows, where four
   pixels side by side are one vector. */
INLINE pixel_sample sample_pixel(__global const float* p, int step, float u, float v) {
  const float16 upper = LOAD16(p - HF_PIXEL), lower = LOAD16(p + step - HF_PIXEL);
  const float8 above = LOAD8(p - step), below = LOAD8(p + 2 * step);
  const float16 row = fma((float16)(v), lower - upper, upper);
  const float8 dy0 = lower.s456789ab - above, dy1 = below - upper.s456789ab;
  const float8 dy = fma((float8)(v), dy1 - dy0, dy0);
  const float8 dx = row.hi - row.lo;
  pixel_sample s;
  s.value = fma((float4)(u), row.s89ab - row.s4567, row.s4567);
  s.dx = 0.5f * fma((float4)(u), dx.hi - dx.lo, dx.lo);
  s.dy = 0.5f * fma((float4)(u), dy.hi - dy.lo, dy.lo);
  return s;
}

/* At (x, y), all inside the sampled region. */
#if HF_STRIPS
INLINE void sample_frame(__global const float* frame, hf_layout layout, lane_float x, lane_float y, lane_int wanted,
                         frame_samples* samples) {
  const int16 xi = convert_int16(x), yi = convert_int16(y);
  float u[16], v[16], value[64], dx[64], dy[64];
  int offset[16], want[16];
  STORE_PRIVATE(x - convert_float16(xi), u);
  STORE_PRIVATE(y - convert_float16(yi), v);
  vstore16((yi * layout.stride + xi + layout.origin) * HF_PIXEL, 0, offset);
  vstore16(wanted, 0, want);
  const int step = HF_PIXEL * layout.stride;
  for (int lane = 0; lane < 16; ++lane) {
    pixel_sample s;
    s.value = s.dx = s.dy = (float4)(0.0f);
    if (want[lane]) s = sample_pixel(frame + offset[lane], step, u[lane], v[lane]);
    STORE4_PRIVATE(s.value, value + 4 * lane);
    STORE4_PRIVATE(s.dx, dx + 4 * lane);
    STORE4_PRIVATE(s.dy, dy + 4 * lane);
  }
  TRANSPOSE_PRIVATE(value, samples->value)
  TRANSPOSE_PRIVATE(dx, samples->dx)
  TRANSPOSE_PRIVATE(dy, samples->dy)
  samples->coverage = COLUMN(LOAD_PRIVATE(value + 0), LOAD_PRIVATE(value + 16), LOAD_PRIVATE(value + 32),
                             LOAD_PRIVATE(value + 48), s37bf);
}

/* At a row's own pixels. */
INLINE void sample_row(__global const float* p, int step, lane_int wanted, frame_samples* samples) {
  const float16 a = LOAD(p), b = LOAD(p + 16), c = LOAD(p + 32), d = LOAD(p + 48);
  TRANSPOSE(a, b, c, d, samples->value)
  samples->coverage = COLUMN(a, b, c, d, s37bf);
#define DIFFERENCE(i, s) (0.5f * (LOAD(p + (i) + (s)) - LOAD(p + (i) - (s))))
  TRANSPOSE(DIFFERENCE(0, HF_PIXEL), DIFFERENCE(16, HF_PIXEL), DIFFERENCE(32, HF_PIXEL), DIFFERENCE(48, HF_PIXEL),
            samples->dx)
  TRANSPOSE(DIFFERENCE(0, step), DIFFERENCE(16, step), DIFFERENCE(32, step), DIFFERENCE(48, step), samples->dy)
#undef DIFFERENCE
  if (!all(wanted)) {
    /* What lies there may be of an earlier frame. */
    const float16 zero = (float16)(0.0f);
#pragma unroll
    for (int c = 0; c < HF_CHANNELS; ++c) {
      samples->value[c] = select(zero, samples->value[c], wanted);
      samples->dx[c] = select(zero, samples->dx[c], wanted);
      samples->dy[c] = select(zero, samples->dy[c], wanted);
    }
  }
}
#else
void sample_frame(__global const float* frame, hf_layout layout, lane_float x, lane_float y, lane_int wanted,
                  frame_samples* samples) {
  const int xi = (int)x, yi = (int)y;
  const pixel_sample s =
      sample_pixel(frame + HF_PIXEL * element(layout, xi, yi), HF_PIXEL * layout.stride, x - xi, y - yi);
  vstore3(s.value.xyz, 0, samples->value);
  vstore3(s.dx.xyz, 0, samples->dx);
  vstore3(s.dy.xyz, 0, samples->dy);
  samples->coverage = s.value.w;
}
#endif

/* One tile (work-item or work-group); `tiles` in units of HF_TILE pixels. Writes the samples (value, d/dx, d/dy in the
   rendered view's axes) and the class of every pixel of the rows that are looked at. */
__kernel void occlusion_tests(__global const float* dx, __global const float* dy, int plane,
                              __global const float* depth, __global const uchar* usable, hf_layout layout,
                              hf_rect tiles, __global const float* frame, hf_warp warp, hf_tests tests,
                              __global const float* pairs, int cell_stride, __global float* samples,
                              __global uchar* classes) {
  const int tx = tiles.x + (int)get_group_id(0), ty = tiles.y + (int)get_group_id(1);
  const int x0 = tx * HF_TILE + TILE_COLUMN;
  lane_float gain[HF_CHANNELS], bias[HF_CHANNELS];
  photometric_rows rows;
  rows.upper_row = NO_CELL_ROW;
  const lane_float column = (lane_float)(x0) + LANE_INDEX;
  const float one_over_fx = 1.0f / warp.fx, one_over_fy = 1.0f / warp.fy;

  for (int row = first_row(ty, warp.every) + TILE_ROW_BEGIN * warp.every; row < HF_TILE;
       row += TILE_ROW_STEP * warp.every) {
    const int y = ty * HF_TILE + row;
    const int e = element(layout, x0, y);
    const lane_int state = TO_INT(LOAD_BYTES(usable + e));
    if (!ANY(state != 0)) {
      STORE_BYTES((lane_uchar)(0), classes + e);
      continue;
    }
    lane_float u = column, v = (lane_float)(y);
    lane_int wanted = state == HF_USED;
    if (!warp.still) {
      const lane_float z = LOAD(depth + e);
      const lane_float px = (column - warp.cx) * one_over_fx * z, py = (lane_float)((y - warp.cy) * one_over_fy) * z;
      const lane_float qx =
          fma((lane_float)(warp.d[0]), px,
              fma((lane_float)(warp.d[1]), py, fma((lane_float)(warp.d[2]), z, (lane_float)(warp.d[3]))));
      const lane_float qy =
          fma((lane_float)(warp.d[4]), px,
              fma((lane_float)(warp.d[5]), py, fma((lane_float)(warp.d[6]), z, (lane_float)(warp.d[7]))));
      const lane_float qz =
          fma((lane_float)(warp.d[8]), px,
              fma((lane_float)(warp.d[9]), py, fma((lane_float)(warp.d[10]), z, (lane_float)(warp.d[11]))));
      const lane_float safe_z = select((lane_float)(1.0f), qz, qz > 1e-6f);
      u = fma(warp.fx * qx, 1.0f / safe_z, (lane_float)(warp.cx));
      v = fma(warp.fy * qy, 1.0f / safe_z, (lane_float)(warp.cy));
      wanted &= qz > 1e-6f;
    }
    wanted &= (u >= warp.min_x) & (v >= warp.min_y) & (u < warp.max_x) & (v < warp.max_y);
    if (!ANY(wanted)) {
      STORE_BYTES(TO_UCHAR(select((lane_int)(HF_NOT_VISIBLE), (lane_int)(HF_UNUSABLE), state != 0)), classes + e);
      continue;
    }
    frame_samples s;
#if HF_STRIPS
    if (warp.still) {
      sample_row(frame + HF_PIXEL * e, HF_PIXEL * layout.stride, wanted, &s);
    } else {
#endif
      const lane_float su = select((lane_float)(warp.min_x), u, wanted),
                       sv = select((lane_float)(warp.min_y), v, wanted);
      sample_frame(frame, layout, su, sv, wanted, &s);
#if HF_STRIPS
    }
#endif
    wanted &= s.coverage >= HF_LEAST_COVERAGE;

    photometric_row(pairs, cell_stride, first_cell(tiles), last_cell(tiles), tx, y, &rows, gain, bias);
    lane_int angle_apart = (lane_int)(0);
    /* The strongest gradient that both images have and that the view has, squared, and by how much the channel farthest
       apart is so: Oclgrind 21.10 gets comparisons of channels, or'ed, wrong. */
    lane_float strongest = (lane_float)(0.0f), strongest_rendered = (lane_float)(0.0f);
    lane_float excess = (lane_float)(-1.0f);
    lane_float along_all = (lane_float)(0.0f), mv2_all = (lane_float)(0.0f), mi2_all = (lane_float)(0.0f);
#pragma unroll
    for (int c = 0; c < HF_CHANNELS; ++c) {
      const lane_float ix = fma((lane_float)(warp.turn[0]), s.dx[c], warp.turn[1] * s.dy[c]);
      const lane_float iy = fma((lane_float)(warp.turn[2]), s.dx[c], warp.turn[3] * s.dy[c]);
      STORE(s.value[c], samples + c * plane + e);
      const lane_float vx = gain[c] * LOAD(dx + c * plane + e), vy = gain[c] * LOAD(dy + c * plane + e);
      const lane_float mv2 = fma(vx, vx, vy * vy), mi2 = fma(ix, ix, iy * iy);
      const lane_float weaker = fmin(mv2, mi2);
      const lane_int strong = weaker > tests.gradient_minimum2;
      const lane_float counted = select((lane_float)(0.0f), (lane_float)(1.0f), strong);
      strongest = fmax(strongest, weaker);
      strongest_rendered = fmax(strongest_rendered, mv2);
      const lane_float along = fma(vx, ix, vy * iy);
      if (tests.angle_together) {
        along_all = fma(counted, along, along_all);
        mv2_all = fma(counted, mv2, mv2_all);
        mi2_all = fma(counted, mi2, mi2_all);
      } else {
        angle_apart |= strong & ((along <= 0.0f) | (along * along < tests.angle_cosine2 * mv2 * mi2));
      }
      const lane_float larger = sqrt(fmax(mv2, mi2));
      const lane_float limit =
          fma((lane_float)(tests.difference_relative), larger, (lane_float)(tests.difference_maximum));
      const lane_float beyond = fma(vx - ix, vx - ix, (vy - iy) * (vy - iy)) - limit * limit;
      excess = select(excess, beyond, beyond > excess);
    }
    const lane_int any_strong = strongest > tests.gradient_minimum2;
    const lane_int any_rendered = strongest_rendered > tests.gradient_minimum2;
    if (tests.angle_together) {
      angle_apart =
          any_strong & ((along_all <= 0.0f) | (along_all * along_all < tests.angle_cosine2 * mv2_all * mi2_all));
    }
    const lane_int apart = excess >= 0.0f;
    lane_int class = (lane_int)(HF_USED);
    if (tests.magnitude_test) class = select(class, (lane_int)(HF_REJECTED_MAGNITUDE), apart);
    if (tests.angle_test) class = select(class, (lane_int)(HF_REJECTED_ANGLE), angle_apart);
    /* Not "!any_strong": Oclgrind 21.10 gets what the compiler makes of that, an unordered comparison, wrong. */
    const lane_int all_weak = strongest <= tests.gradient_minimum2;
    if (tests.gradient_test) class = select(class, (lane_int)(HF_NO_GRADIENT), all_weak);
    const lane_int counts = any_rendered | (tests.magnitude_test ? apart : (lane_int)(0));
    class |= select((lane_int)(0), (lane_int)(HF_COUNTS_IN_VOTE), counts);
    class = select((lane_int)(HF_UNUSABLE), class, wanted);
    class = select((lane_int)(HF_NOT_VISIBLE), class, state != 0);
    STORE_BYTES(TO_UCHAR(class), classes + e);
  }
}
