/* Block vote, flow constraints of the surviving pixels and their sums, a tile at a time: equations 10, 11b and 13
   of docs/math.md. */

#if HF_STRIPS
/* Of every column beside a row's lanes, eight more on either side: pixels of the neighbourhood's rows that count and,
   256 times, that pass. */
typedef struct {
  ushort16 half_row[2];
} vote_columns;

INLINE ushort16 votes(__global const uchar* classes) {
  const uchar16 c = LOAD_BYTES(classes);
  const uchar16 counted = c >> (uchar)4;
  const uchar16 passed = as_uchar16((c & (uchar)15) == (uchar16)(HF_USED)) & counted;
  return convert_ushort16(counted) | (convert_ushort16(passed) << (ushort)8);
}

INLINE void add_row(__global const uchar* row, vote_columns* columns) {
  columns->half_row[0] += votes(row);
  columns->half_row[1] += votes(row + 16);
}

INLINE void remove_row(__global const uchar* row, vote_columns* columns) {
  columns->half_row[0] -= votes(row);
  columns->half_row[1] -= votes(row + 16);
}

INLINE ushort16 neighbourhood_sum(const vote_columns* columns, int radius) {
  ushort line[32];
  vstore16(columns->half_row[0], 0, line);
  vstore16(columns->half_row[1], 1, line);
  ushort16 sum = (ushort16)(0);
  for (int i = -radius; i <= radius; ++i) sum += vload16(0, line + 8 + i);
  return sum;
}

/* Neighbouring lanes added up: half as many of each vector. */
INLINE float16 add_pairs(float16 a, float16 b) { return (float16)(a.even, b.even) + (float16)(a.odd, b.odd); }

/* Of eight vectors: the sum of a vector's lower eight lanes, then of its upper eight, one vector after the other. */
INLINE float16 half_sums(const float16* v) {
  return add_pairs(add_pairs(add_pairs(v[0], v[1]), add_pairs(v[2], v[3])),
                   add_pairs(add_pairs(v[4], v[5]), add_pairs(v[6], v[7])));
}

INLINE float16 sixteen_sums(const float16* v) { return add_pairs(half_sums(v), half_sums(v + 8)); }

/* As many vectors as are added up at once. */
#define MAIN_LANES ((HF_SUM_MAIN + 15) / 16 * 16)
#define CELL_LANES ((HF_CELL_SUMS + 7) / 8 * 8)
#else
#define MAIN_LANES HF_SUM_MAIN
#define CELL_LANES HF_CELL_SUMS
#endif

__kernel void flow_constraints(__global const float* value, __global const float* dx, __global const float* dy,
                               int plane, __global const float* depth, hf_layout layout, hf_rect tiles,
                               __global const float* samples, __global const uchar* classes, hf_constraints k,
                               __global const float* pairs, int cell_stride, __global uchar* final_classes,
                               __global float* sums) {
  const int tx = tiles.x + (int)get_group_id(0), ty = tiles.y + (int)get_group_id(1);
  const int x0 = tx * HF_TILE + TILE_COLUMN;
  __global float* out = sums + HF_SUM_STRIDE * ((int)get_group_id(1) * tiles.width + (int)get_group_id(0));
  const lane_float zero = (lane_float)(0.0f), one = (lane_float)(1.0f);
  lane_float total[MAIN_LANES];
#pragma unroll
  for (int i = 0; i < MAIN_LANES; ++i) total[i] = zero;
#if HF_STRIPS
  /* Many tiles hold no pixel that passed: they are counted and done with. In floats, chosen: Oclgrind 21.10 counts 255
     where a comparison's -1 is subtracted from an integer. */
  float16 visible = zero, usable = zero, gradient = zero, passing = zero;
  for (int row = first_row(ty, k.every); row < HF_TILE; row += k.every) {
    const int e = element(layout, x0, ty * HF_TILE + row);
    const uchar16 class = LOAD_BYTES(classes + e);
    if (!any(class != (uchar)0)) {
      STORE_BYTES(class, final_classes + e);
      continue;
    }
    const int16 c = convert_int16(class & (uchar)15);
    visible += select(zero, one, c != HF_NOT_VISIBLE);
    usable += select(zero, one, c >= HF_NO_GRADIENT);
    gradient += select(zero, one, convert_int16(class) >= HF_COUNTS_IN_VOTE);
    passing += select(zero, one, c == HF_USED);
    STORE_BYTES(class & (uchar)15, final_classes + e);
  }
  total[HF_SUM_VISIBLE] = visible;
  total[HF_SUM_USABLE] = usable;
  total[HF_SUM_GRADIENT] = gradient;
  total[HF_SUM_PASSED] = passing;
  if (!any(passing > zero)) {
    for (int i = 0; i < MAIN_LANES; i += 16) STORE(sixteen_sums(total + i), out + i);
    for (int i = MAIN_LANES; i < HF_SUM_STRIDE; i += 16) STORE(zero, out + i);
    return;
  }
#endif
  lane_float gain[HF_CHANNELS], bias[HF_CHANNELS];
  photometric_rows rows;
  rows.upper_row = NO_CELL_ROW;
  lane_float photo[2][CELL_LANES];
#pragma unroll
  for (int i = 0; i < CELL_LANES; ++i) photo[0][i] = photo[1][i] = zero;
  const lane_float ray_x = ((lane_float)(x0) + LANE_INDEX - k.cx) / k.fx;

#if HF_STRIPS
  vote_columns columns;
  const int reach = k.vote_radius / k.every; /* rows that are looked at, up and down */
  if (k.block_vote) {
    columns.half_row[0] = columns.half_row[1] = (ushort16)(0);
    for (int i = -reach; i < reach; ++i) {
      add_row(classes + element(layout, x0 - 8, ty * HF_TILE + first_row(ty, k.every) + i * k.every), &columns);
    }
  }
#endif

  for (int row = first_row(ty, k.every) + TILE_ROW_BEGIN * k.every; row < HF_TILE; row += TILE_ROW_STEP * k.every) {
    const int y = ty * HF_TILE + row;
    const int e = element(layout, x0, y);
    lane_int class = TO_INT(LOAD_BYTES(classes + e));
#if HF_STRIPS
    if (k.block_vote) {
      add_row(classes + element(layout, x0 - 8, y + reach * k.every), &columns);
      if (row >= k.every) remove_row(classes + element(layout, x0 - 8, y - (reach + 1) * k.every), &columns);
    }
#else
    const lane_int counts = (class & HF_COUNTS_IN_VOTE) != 0;
#endif
    class &= 15;
    lane_int used = class == HF_USED;
#if HF_STRIPS
    if (!any(used)) continue; /* counted already */
#else
    total[HF_SUM_VISIBLE] += select(zero, one, class != HF_NOT_VISIBLE);
    total[HF_SUM_USABLE] += select(zero, one, class >= HF_NO_GRADIENT);
    total[HF_SUM_GRADIENT] += select(zero, one, counts);
    total[HF_SUM_PASSED] += select(zero, one, used);
#endif
    if (k.block_vote && ANY(used)) {
#if HF_STRIPS
      const ushort16 both = neighbourhood_sum(&columns, k.vote_radius);
      const int16 counted = convert_int16(both & (ushort)255), passed = convert_int16(both >> (ushort)8);
#else
      int counted = 0, passed = 0;
      for (int j = -(k.vote_radius / k.every * k.every); j <= k.vote_radius; j += k.every) {
        for (int i = -k.vote_radius; i <= k.vote_radius; ++i) {
          const int c = classes[element(layout, x0 + i, y + j)];
          const int counting = c >> 4;
          counted += counting;
          passed += (c & 15) == HF_USED ? counting : 0;
        }
      }
#endif
      const lane_int outvoted = used & (TO_FLOAT(passed) < k.vote_share * TO_FLOAT(counted));
      class = select(class, (lane_int)(HF_REJECTED_VOTE), outvoted);
      used = class == HF_USED;
    }
    STORE_BYTES(TO_UCHAR(class), final_classes + e);
    if (!ANY(used)) continue;
    const lane_float mask = select(zero, one, used);
    total[HF_SUM_USED] += mask;

    photometric_row(pairs, cell_stride, first_cell(tiles), last_cell(tiles), tx, y, &rows, gain, bias);
    lane_float* cell = photo[row / HF_CELL];
    lane_float gx[HF_CHANNELS], gy[HF_CHANNELS], vx[HF_CHANNELS], vy[HF_CHANNELS], m2[HF_CHANNELS];
#pragma unroll
    for (int c = 0; c < HF_CHANNELS; ++c) {
      vx[c] = gain[c] * LOAD(dx + c * plane + e);
      vy[c] = gain[c] * LOAD(dy + c * plane + e);
      gx[c] = vx[c];
      gy[c] = vy[c];
      m2[c] = fma(vx[c], vx[c], vy[c] * vy[c]);
    }
    /* Strongest channel, for the redundancy test; the first of equals. */
    lane_float strongest = m2[0], sx = vx[0], sy = vy[0];
    lane_int strongest_channel = (lane_int)(0);
#pragma unroll
    for (int c = 1; c < HF_CHANNELS; ++c) {
      const lane_int stronger = m2[c] > strongest;
      strongest = select(strongest, m2[c], stronger);
      sx = select(sx, vx[c], stronger);
      sy = select(sy, vy[c], stronger);
      strongest_channel = select(strongest_channel, (lane_int)(c), stronger);
    }

    /* Rows that repeat a leading channel's are added to its row: their gradients are taken along its own (13a). */
    lane_int second_channel = (lane_int)(-1);
    if (k.redundancy) {
      lane_float second = (lane_float)(k.gradient_minimum2), tx = zero, ty = zero;
#pragma unroll
      for (int c = 0; c < HF_CHANNELS; ++c) {
        const lane_float along = fma(vx[c], sx, vy[c] * sy);
        const lane_int leads = (along * along <= k.redundancy_cosine2 * m2[c] * strongest) & (m2[c] > second);
        second = select(second, m2[c], leads);
        tx = select(tx, vx[c], leads);
        ty = select(ty, vy[c], leads);
        second_channel = select(second_channel, (lane_int)(c), leads);
      }
      const lane_float first_x = sx, first_y = sy, second_x = tx, second_y = ty;
#pragma unroll
      for (int c = 0; c < HF_CHANNELS; ++c) {
        const lane_float by_first = fma(vx[c], sx, vy[c] * sy), by_second = fma(vx[c], tx, vy[c] * ty);
        /* Whichever it is nearer to in direction. */
        const lane_int to_second =
            (second_channel >= 0) & (by_second * by_second * strongest > by_first * by_first * second);
        const lane_float ox = select(first_x, second_x, to_second), oy = select(first_y, second_y, to_second);
        const lane_float length2 = fma(ox, ox, oy * oy);
        const lane_float share = fma(gx[c], ox, gy[c] * oy) / select(one, length2, length2 > 0.0f);
        const lane_int leading = (strongest_channel == c) | (second_channel == c);
        gx[c] = select(share * ox, gx[c], leading);
        gy[c] = select(share * oy, gy[c], leading);
      }
    }

    lane_float g11 = zero, g12 = zero, g22 = zero, q1 = zero, q2 = zero;
#pragma unroll
    for (int c = 0; c < HF_CHANNELS; ++c) {
      const lane_float rendered = LOAD(value + c * plane + e), seen = LOAD(samples + c * plane + e);
      const lane_float r = fma(gain[c], rendered, bias[c]) - seen;
      const lane_float r2 = r * r;
      lane_float weight = mask;
      if (k.robust) weight *= (k.freedom + 1.0f) / fma((lane_float)(k.inverse_scale2), r2, (lane_float)(k.freedom));
      weight = select(weight, zero, seen >= k.saturated); /* still a row, one that agrees as far as it can */
      const int p = HF_PHOTO * c;
      const lane_float wv = weight * rendered, wi = weight * seen;
      cell[p] += weight;
      cell[p + 1] += wv;
      cell[p + 2] += wi;
      cell[p + 3] = fma(wv, rendered, cell[p + 3]);
      cell[p + 4] = fma(wi, seen, cell[p + 4]);
      cell[p + 5] = fma(wv, seen, cell[p + 5]);
      if (k.elimination) {
        cell[p + 6] = fma(weight, r, cell[p + 6]);
        cell[p + 7] = fma(wv, r, cell[p + 7]);
        cell[p + 8] = fma(weight, gx[c], cell[p + 8]);
        cell[p + 9] = fma(weight, gy[c], cell[p + 9]);
        cell[p + 10] = fma(wv, gx[c], cell[p + 10]);
        cell[p + 11] = fma(wv, gy[c], cell[p + 11]);
      }
      lane_int keep = used & (m2[c] > 0.0f);
      if (k.redundancy) keep &= (strongest_channel == c) | (second_channel == c);
      total[HF_SUM_ROWS] += select(zero, one, keep);
      total[HF_SUM_W] += select(zero, weight, keep);
      total[HF_SUM_WRR] = fma(select(zero, weight, keep), r2, total[HF_SUM_WRR]);
      const lane_float wx = weight * gx[c], wy = weight * gy[c];
      g11 = fma(wx, gx[c], g11);
      g12 = fma(wx, gy[c], g12);
      g22 = fma(wy, gy[c], g22);
      q1 = fma(wx, r, q1);
      q2 = fma(wy, r, q2);
    }

    /* The 2x6 geometry L of this pixel, conditioned: translation scaled by the radius, rotation about the centre. */
    const lane_float z = LOAD(depth + e);
    cell[HF_CELL_PIXELS] += mask;
    cell[HF_CELL_DEPTH] = fma(mask, z, cell[HF_CELL_DEPTH]);
    const lane_float inverse_z = 1.0f / select(one, z, z > 0.0f);
    const float ray_y = (y - k.cy) / k.fy;
    const lane_float ax = fma(ray_x, z, (lane_float)(-k.center[0])),
                     ay = fma((lane_float)(ray_y), z, (lane_float)(-k.center[1]));
    const lane_float az = z - k.center[2];
    const lane_float u0 = k.fx * inverse_z, u2 = -u0 * ray_x;
    const lane_float v1 = k.fy * inverse_z, v2 = -v1 * ray_y;
    lane_float ju[6], jv[6];
    ju[0] = k.radius * u0;
    ju[1] = zero;
    ju[2] = k.radius * u2;
    ju[3] = ay * u2;
    ju[4] = fma(az, u0, -(ax * u2));
    ju[5] = -(ay * u0);
    jv[0] = zero;
    jv[1] = k.radius * v1;
    jv[2] = k.radius * v2;
    jv[3] = fma(ay, v2, -(az * v1));
    jv[4] = -(ax * v2);
    jv[5] = ax * v1;
    /* ju[1] and jv[0] are nought: what they would add is left out. */
    lane_float bu[6], bv[6];
    bu[0] = g11 * ju[0];
    bv[0] = g12 * ju[0];
    bu[1] = g12 * jv[1];
    bv[1] = g22 * jv[1];
    total[HF_SUM_H] = fma(ju[0], q1, total[HF_SUM_H]);
    total[HF_SUM_H + 1] = fma(jv[1], q2, total[HF_SUM_H + 1]);
#pragma unroll
    for (int i = 2; i < 6; ++i) {
      bu[i] = fma(g11, ju[i], g12 * jv[i]);
      bv[i] = fma(g12, ju[i], g22 * jv[i]);
      total[HF_SUM_H + i] = fma(ju[i], q1, fma(jv[i], q2, total[HF_SUM_H + i]));
    }
#pragma unroll
    for (int j = 0; j < 6; ++j) total[HF_SUM_A + j] = fma(ju[0], bu[j], total[HF_SUM_A + j]);
#pragma unroll
    for (int j = 1; j < 6; ++j) total[HF_SUM_A + 5 + j] = fma(jv[1], bv[j], total[HF_SUM_A + 5 + j]);
    int n = 11;
#pragma unroll
    for (int i = 2; i < 6; ++i) {
#pragma unroll
      for (int j = i; j < 6; ++j) {
        total[HF_SUM_A + n] = fma(ju[i], bu[j], fma(jv[i], bv[j], total[HF_SUM_A + n]));
        ++n;
      }
    }
  }

#if HF_STRIPS
  /* What is stored past the end of some sums is overwritten by the next; behind the last there is room. */
  for (int i = 0; i < MAIN_LANES; i += 16) STORE(sixteen_sums(total + i), out + i);
  for (int half_row = 0; half_row < 2; ++half_row) {
    __global float* left = out + HF_SUM_PHOTO + 2 * half_row * HF_CELL_SUMS;
    float8 right[CELL_LANES / 8];
    for (int i = 0; i < CELL_LANES; i += 8) {
      const float16 both = half_sums(photo[half_row] + i);
      STORE8(both.even, left + i);
      right[i / 8] = both.odd;
    }
    for (int i = 0; i < CELL_LANES; i += 8) STORE8(right[i / 8], left + HF_CELL_SUMS + i);
  }
#else
#define HF_LANE_SUMS (HF_SUM_MAIN + 2 * HF_CELL_SUMS) /* odd: spreads the columns over the banks */
  __local float partial[HF_GROUP * HF_LANE_SUMS];
  const int lane = (int)get_local_id(0);
  for (int i = 0; i < HF_SUM_MAIN; ++i) partial[lane * HF_LANE_SUMS + i] = total[i];
  for (int i = 0; i < HF_CELL_SUMS; ++i) {
    partial[lane * HF_LANE_SUMS + HF_SUM_MAIN + i] = photo[0][i];
    partial[lane * HF_LANE_SUMS + HF_SUM_MAIN + HF_CELL_SUMS + i] = photo[1][i];
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  for (int i = lane; i < HF_LANE_SUMS; i += HF_GROUP) {
    /* Lanes 0 to 7 of each row of 16 are the left cells', 8 to 15 the right cells'. */
    float left = 0.0f, right = 0.0f;
    for (int row = 0; row < HF_GROUP / HF_TILE; ++row) {
      for (int column = 0; column < HF_CELL; ++column) {
        left += partial[(row * HF_TILE + column) * HF_LANE_SUMS + i];
        right += partial[(row * HF_TILE + HF_CELL + column) * HF_LANE_SUMS + i];
      }
    }
    if (i < HF_SUM_MAIN) {
      out[i] = left + right;
    } else {
      const int half_row = (i - HF_SUM_MAIN) / HF_CELL_SUMS, sum = (i - HF_SUM_MAIN) % HF_CELL_SUMS;
      out[HF_SUM_PHOTO + (2 * half_row) * HF_CELL_SUMS + sum] = left;
      out[HF_SUM_PHOTO + (2 * half_row + 1) * HF_CELL_SUMS + sum] = right;
    }
  }
#endif
}
