/* Samples the frame where each rendered pixel lies now and compares gradients: equations 5 and 7 to 10 of
   docs/math.md. */

typedef struct {
  lane_float v[HF_SAMPLES];
} warped_samples;

/* Bilinear samples of value and gradient at (x, y), all inside the sampled region. */
#if HF_STRIPS
void sample_features(__global const float* features, hf_layout layout, lane_float x, lane_float y, lane_int wanted,
                     warped_samples* samples) {
  const int16 xi = convert_int16(x), yi = convert_int16(y);
  float fx[16], fy[16], out[HF_SAMPLES][16];
  int offset[16], want[16];
  vstore16(x - convert_float16(xi), 0, fx);
  vstore16(y - convert_float16(yi), 0, fy);
  vstore16((yi * layout.stride + xi + layout.origin) * HF_FEATURE, 0, offset);
  vstore16(wanted, 0, want);
  const int step = HF_FEATURE * layout.stride;
  for (int lane = 0; lane < 16; ++lane) {
    float4 s[3] = {(float4)(0.0f), (float4)(0.0f), (float4)(0.0f)};
    if (want[lane]) {
      __global const float* p = features + offset[lane];
      const float u = fx[lane], v = fy[lane];
      const float w11 = u * v, w10 = v - w11, w01 = u - w11, w00 = 1.0f - u - w10;
      for (int k = 0; k < 3; ++k) {
        float4 sum = w00 * vload4(0, p + 3 * k);
        sum = fma((float4)(w01), vload4(0, p + HF_FEATURE + 3 * k), sum);
        sum = fma((float4)(w10), vload4(0, p + step + 3 * k), sum);
        s[k] = fma((float4)(w11), vload4(0, p + step + HF_FEATURE + 3 * k), sum);
      }
    }
    for (int k = 0; k < 3; ++k) {
      out[3 * k][lane] = s[k].x;
      out[3 * k + 1][lane] = s[k].y;
      out[3 * k + 2][lane] = s[k].z;
    }
  }
  for (int k = 0; k < HF_SAMPLES; ++k) samples->v[k] = vload16(0, out[k]);
}
#else
void sample_features(__global const float* features, hf_layout layout, lane_float x, lane_float y, lane_int wanted,
                     warped_samples* samples) {
  const int xi = (int)x, yi = (int)y;
  const float u = x - xi, v = y - yi;
  const float w11 = u * v, w10 = v - w11, w01 = u - w11, w00 = 1.0f - u - w10;
  __global const float* p = features + HF_FEATURE * element(layout, xi, yi);
  const int step = HF_FEATURE * layout.stride;
  for (int k = 0; k < 3; ++k) {
    float4 sum = w00 * vload4(0, p + 3 * k);
    sum = fma((float4)(w01), vload4(0, p + HF_FEATURE + 3 * k), sum);
    sum = fma((float4)(w10), vload4(0, p + step + 3 * k), sum);
    sum = fma((float4)(w11), vload4(0, p + step + HF_FEATURE + 3 * k), sum);
    samples->v[3 * k] = sum.x;
    samples->v[3 * k + 1] = sum.y;
    samples->v[3 * k + 2] = sum.z;
  }
}
#endif

/* One tile (work-item or work-group); `tiles` in units of HF_TILE pixels. Writes the samples (value, d/dx, d/dy in the
   rendered view's axes) and the class of every pixel of the tile. */
__kernel void occlusion_tests(__global const float* value, __global const float* dx, __global const float* dy,
                              int plane, __global const float* depth, __global const uchar* usable, hf_layout layout,
                              hf_rect tiles, __global const float* features, hf_warp warp, hf_tests tests,
                              __global const float* pairs, int cell_stride, __global float* samples,
                              __global uchar* classes) {
  const int tx = tiles.x + (int)get_group_id(0), ty = tiles.y + (int)get_group_id(1);
  const int x0 = tx * HF_TILE + TILE_COLUMN;
  lane_float gain[HF_CHANNELS], bias[HF_CHANNELS];
  const lane_float column = (lane_float)(x0) + LANE_INDEX;
  const float one_over_fx = 1.0f / warp.fx, one_over_fy = 1.0f / warp.fy;

  for (int row = TILE_ROW_BEGIN; row < HF_TILE; row += TILE_ROW_STEP) {
    const int y = ty * HF_TILE + row;
    const int e = element(layout, x0, y);
    const lane_int state = TO_INT(LOAD(usable + e));
    if (!ANY(state != 0)) {
      STORE((lane_uchar)(0), classes + e);
      continue;
    }
    if ((tx + ty) % warp.thinning != 0) {
      STORE(TO_UCHAR(CHOOSE((lane_int)(HF_NOT_VISIBLE), (lane_int)(HF_UNUSABLE), state != 0)), classes + e);
      continue;
    }
    const lane_float z = LOAD(depth + e);
    const lane_float px = (column - warp.cx) * one_over_fx * z, py = (lane_float)((y - warp.cy) * one_over_fy) * z;
    const lane_float qx = fma((lane_float)(warp.d[0]), px, fma((lane_float)(warp.d[1]), py,
                              fma((lane_float)(warp.d[2]), z, (lane_float)(warp.d[3]))));
    const lane_float qy = fma((lane_float)(warp.d[4]), px, fma((lane_float)(warp.d[5]), py,
                              fma((lane_float)(warp.d[6]), z, (lane_float)(warp.d[7]))));
    const lane_float qz = fma((lane_float)(warp.d[8]), px, fma((lane_float)(warp.d[9]), py,
                              fma((lane_float)(warp.d[10]), z, (lane_float)(warp.d[11]))));
    const lane_float safe_z = CHOOSE((lane_float)(1.0f), qz, qz > 1e-6f);
    const lane_float u = fma(warp.fx * qx, 1.0f / safe_z, (lane_float)(warp.cx));
    const lane_float v = fma(warp.fy * qy, 1.0f / safe_z, (lane_float)(warp.cy));
    const lane_int wanted = (state == HF_USED) & (qz > 1e-6f) & (u >= warp.min_x) & (v >= warp.min_y) &
                            (u < warp.max_x) & (v < warp.max_y);
    if (!ANY(wanted)) {
      STORE(TO_UCHAR(CHOOSE((lane_int)(HF_NOT_VISIBLE), (lane_int)(HF_UNUSABLE), state != 0)), classes + e);
      continue;
    }
    const lane_float su = CHOOSE((lane_float)(warp.min_x), u, wanted), sv = CHOOSE((lane_float)(warp.min_y), v, wanted);
    warped_samples s;
    sample_features(features, layout, su, sv, wanted, &s);

    photometric_row(pairs, cell_stride, first_cell(tiles), last_cell(tiles), tx, y, gain, bias);
    lane_int any_strong = (lane_int)(0), all_strong = ~(lane_int)(0), any_rendered = (lane_int)(0);
    lane_int angle_apart = (lane_int)(0), apart = (lane_int)(0);
    for (int c = 0; c < HF_CHANNELS; ++c) {
      const lane_float ix = fma((lane_float)(warp.turn[0]), s.v[3 + c], warp.turn[1] * s.v[6 + c]);
      const lane_float iy = fma((lane_float)(warp.turn[2]), s.v[3 + c], warp.turn[3] * s.v[6 + c]);
      STORE(s.v[c], samples + c * plane + e);
      STORE(ix, samples + (3 + c) * plane + e);
      STORE(iy, samples + (6 + c) * plane + e);
      const lane_float vx = gain[c] * LOAD(dx + c * plane + e), vy = gain[c] * LOAD(dy + c * plane + e);
      const lane_float mv2 = fma(vx, vx, vy * vy), mi2 = fma(ix, ix, iy * iy);
      const lane_int rendered = mv2 > tests.gradient_minimum2;
      const lane_int strong = rendered & (mi2 > tests.gradient_minimum2);
      any_strong |= strong;
      if (c < tests.channels) all_strong &= strong;
      any_rendered |= rendered;
      const lane_float along = fma(vx, ix, vy * iy);
      angle_apart |= strong & ((along <= 0.0f) | (along * along < tests.angle_cosine2 * mv2 * mi2));
      const lane_float larger = sqrt(fmax(mv2, mi2));
      const lane_float limit = fma((lane_float)(tests.difference_relative), larger,
                                   (lane_float)(tests.difference_maximum));
      lane_float difference;
      if (tests.compare_magnitudes) {
        difference = larger - sqrt(fmin(mv2, mi2));
      } else {
        difference = sqrt(fma(vx - ix, vx - ix, (vy - iy) * (vy - iy)));
      }
      apart |= difference >= limit;
    }
    const lane_int gradients = tests.all_channels ? all_strong : any_strong;
    lane_int class = (lane_int)(HF_USED);
    if (tests.magnitude_test) class = CHOOSE(class, (lane_int)(HF_REJECTED_MAGNITUDE), apart);
    if (tests.angle_test) class = CHOOSE(class, (lane_int)(HF_REJECTED_ANGLE), angle_apart);
    if (tests.gradient_test) class = CHOOSE(class, (lane_int)(HF_NO_GRADIENT), !gradients);
    const lane_int counts = any_rendered | (tests.magnitude_test ? apart : (lane_int)(0));
    class |= CHOOSE((lane_int)(0), (lane_int)(HF_COUNTS_IN_VOTE), counts);
    class = CHOOSE((lane_int)(HF_UNUSABLE), class, wanted);
    class = CHOOSE((lane_int)(HF_NOT_VISIBLE), class, state != 0);
    STORE(TO_UCHAR(class), classes + e);
  }
}
