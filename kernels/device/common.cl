/* How work is divided. HF_STRIPS: a work-item walks a whole row or tile with explicit vectors of 16 lanes (CPU
   devices). Otherwise a work-item is one lane and a tile is one work-group of HF_GROUP items (GPUs). */
#pragma OPENCL FP_CONTRACT OFF

/* Vectors of 16 as arguments of a real call would go through memory. */
#define INLINE __attribute__((always_inline)) inline

#if HF_STRIPS
#define LANES 16
typedef float16 lane_float;
typedef int16 lane_int;
typedef uchar16 lane_uchar;
/* Vectors at any address. Not vload and vstore: PoCL 3.1 takes their vectors apart. */
typedef struct __attribute__((packed)) {
  float16 v;
} packed_float16;
typedef struct __attribute__((packed)) {
  uchar16 v;
} packed_uchar16;
typedef struct __attribute__((packed)) {
  float8 v;
} packed_float8;
typedef struct __attribute__((packed)) {
  float4 v;
} packed_float4;
#define LOAD(p) (((__global const packed_float16*)(p))->v)
#define STORE(x, p) (((__global packed_float16*)(p))->v = (x))
#define LOAD_BYTES(p) (((__global const packed_uchar16*)(p))->v)
#define STORE_BYTES(x, p) (((__global packed_uchar16*)(p))->v = (x))
#define LOAD8(p) (((__global const packed_float8*)(p))->v)
#define LOAD16(p) LOAD(p)
#define STORE8(x, p) (((__global packed_float8*)(p))->v = (x))
#define LOAD_PRIVATE(p) (((const packed_float16*)(p))->v)
#define STORE_PRIVATE(x, p) (((packed_float16*)(p))->v = (x))
#define STORE4_PRIVATE(x, p) (((packed_float4*)(p))->v = (x))
#define TO_INT(v) convert_int16(v)
#define TO_FLOAT(v) convert_float16(v)
#define TO_UCHAR(v) convert_uchar16(v)
#define LANE_INDEX ((float16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15))
#define ANY(mask) any(mask)
#define TILE_ROW_BEGIN 0
#define TILE_ROW_STEP 1
#define TILE_COLUMN 0
#define ROW_X_BEGIN 0
#define ROW_X_END(width) (width)
/* Interleaved pixels: four at once. */
typedef float16 pixel_vector;
#define PIXELS_AT_ONCE 4
#define LOAD_PIXELS(p) LOAD(p)
#define STORE_PIXELS(v, p) STORE(v, p)
/* One number of each of these. */
typedef float4 pixel_lane;
#define CHANNEL_0(v) (v).s048c
#define CHANNEL_1(v) (v).s159d
#define CHANNEL_2(v) (v).s26ae
#define CHANNEL_3(v) (v).s37bf
#define LOAD_LANE(p) (((__global const packed_float4*)(p))->v)
#define STORE_LANE(x, p) (((__global packed_float4*)(p))->v = (x))
#define LOAD_PIXEL_BYTES(p) LOAD_BYTES(p)
#define CONVERT_PIXELS(v) convert_float16(v)
#define INTERLEAVED(a, b, c, d)                                                                                      \
  ((float16)((a).s0, (b).s0, (c).s0, (d).s0, (a).s1, (b).s1, (c).s1, (d).s1, (a).s2, (b).s2, (c).s2, (d).s2, (a).s3, \
             (b).s3, (c).s3, (d).s3))
#else
#define LANES 1
typedef float lane_float;
typedef int lane_int;
typedef uchar lane_uchar;
#define LOAD(p) (*(p))
#define STORE(x, p) (*(p) = (x))
#define LOAD_BYTES(p) (*(p))
#define STORE_BYTES(x, p) (*(p) = (x))
#define LOAD8(p) vload8(0, (p))
#define LOAD16(p) vload16(0, (p))
#define TO_INT(v) ((int)(v))
#define TO_FLOAT(v) ((float)(v))
#define TO_UCHAR(v) ((uchar)(v))
#define LANE_INDEX 0.0f
#define ANY(mask) ((mask) != 0)
#define TILE_ROW_BEGIN ((int)get_local_id(0) / HF_TILE)
#define TILE_ROW_STEP (HF_GROUP / HF_TILE)
#define TILE_COLUMN ((int)get_local_id(0) % HF_TILE)
#define ROW_X_BEGIN ((int)get_global_id(0))
#define ROW_X_END(width) min((int)get_global_id(0) + 1, (width))
typedef float4 pixel_vector;
#define PIXELS_AT_ONCE 1
#define LOAD_PIXELS(p) vload4(0, (p))
#define STORE_PIXELS(v, p) vstore4((v), 0, (p))
typedef float pixel_lane;
#define CHANNEL_0(v) (v).x
#define CHANNEL_1(v) (v).y
#define CHANNEL_2(v) (v).z
#define CHANNEL_3(v) (v).w
#define LOAD_LANE(p) (*(p))
#define STORE_LANE(v, p) (*(p) = (v))
#define LOAD_PIXEL_BYTES(p) vload4(0, (p))
#define CONVERT_PIXELS(v) convert_float4(v)
#define INTERLEAVED(a, b, c, d) ((float4)((a), (b), (c), (d)))
#endif

#if HF_STRIPS
/* Sixteen vectors of four -> four of sixteen. */
#define COLUMN(a, b, c, d, s) (float16)((a).s, (b).s, (c).s, (d).s)
#define TRANSPOSE(a, b, c, d, out)      \
  {                                     \
    out[0] = COLUMN(a, b, c, d, s048c); \
    out[1] = COLUMN(a, b, c, d, s159d); \
    out[2] = COLUMN(a, b, c, d, s26ae); \
  }
#define TRANSPOSE_PRIVATE(in, out) \
  TRANSPOSE(LOAD_PRIVATE(in), LOAD_PRIVATE((in) + 16), LOAD_PRIVATE((in) + 32), LOAD_PRIVATE((in) + 48), out)

/* Two vectors' elements in turn, from their lower or their upper halves. */
#define IN_TURN(a, b)                                                                                                \
  ((float16)((a).s0, (b).s0, (a).s1, (b).s1, (a).s2, (b).s2, (a).s3, (b).s3, (a).s4, (b).s4, (a).s5, (b).s5, (a).s6, \
             (b).s6, (a).s7, (b).s7))
#define PAIRS_IN_TURN(a, b) as_float16((ulong8)((a).s0, (b).s0, (a).s1, (b).s1, (a).s2, (b).s2, (a).s3, (b).s3))
/* Planes -> interleaved pixels: as many of the lanes as `columns`, in whole fours. */
INLINE void store_interleaved(float16 r, float16 g, float16 b, float16 coverage, int columns, __global float* out) {
  const ulong8 rg_low = as_ulong8(IN_TURN(r.lo, g.lo)), rg_high = as_ulong8(IN_TURN(r.hi, g.hi));
  const ulong8 bc_low = as_ulong8(IN_TURN(b.lo, coverage.lo)), bc_high = as_ulong8(IN_TURN(b.hi, coverage.hi));
  STORE(PAIRS_IN_TURN(rg_low.lo, bc_low.lo), out);
  if (columns > 4) STORE(PAIRS_IN_TURN(rg_low.hi, bc_low.hi), out + 16);
  if (columns > 8) STORE(PAIRS_IN_TURN(rg_high.lo, bc_high.lo), out + 32);
  if (columns > 12) STORE(PAIRS_IN_TURN(rg_high.hi, bc_high.hi), out + 48);
}
#else
INLINE void store_interleaved(float r, float g, float b, float coverage, int columns, __global float* out) {
  vstore4((float4)(r, g, b, coverage), 0, out);
}
#endif

/* Brightness of encoded red, green and blue, as BT.601 weighs them. */
#define LUMA(r, g, b) (0.299f * (r) + 0.587f * (g) + 0.114f * (b))

int element(hf_layout layout, int x, int y) { return layout.origin + y * layout.stride + x; }

/* First row of a tile on the grid of rows that are looked at, which starts at the image's first row. */
int first_row(int tile_y, int every) { return (every - tile_y * HF_TILE % every) % every; }

/* Gain and bias (three of each) of every lane of a tile's rows, as they are on the rows of cells above and below the
   row that was asked for last. */
typedef struct {
  lane_float upper[2 * HF_CHANNELS], lower[2 * HF_CHANNELS];
  int upper_row;
} photometric_rows;

/* No row of cells: what is asked for first is made. */
#define NO_CELL_ROW (-1000000)

/* On the middle of a row of cells, linear between the centres of its cells. `first` and `last` bound the cells that
   hold values. */
INLINE void photometric_cells(__global const float* pairs, int cell_stride, int2 first, int2 last, int tile_x,
                              int cell_row, lane_float* pair) {
  __global const float* row = pairs + HF_CELL_PAIRS * cell_stride * clamp(cell_row, first.y, last.y);
  const lane_float position = ((lane_float)(TILE_COLUMN) + LANE_INDEX - 0.5f * (HF_CELL - 1)) * (1.0f / HF_CELL);
#pragma unroll
  for (int i = 0; i < 2 * HF_CHANNELS; ++i) pair[i] = (lane_float)(0.0f);
#pragma unroll
  for (int k = -1; k <= HF_TILE / HF_CELL; ++k) {
    const lane_float weight = fmax((lane_float)(0.0f), 1.0f - fabs(position - (float)k));
    __global const float* cell = row + HF_CELL_PAIRS * clamp(tile_x * (HF_TILE / HF_CELL) + k, first.x, last.x);
#pragma unroll
    for (int i = 0; i < 2 * HF_CHANNELS; ++i) pair[i] = fma(weight, (lane_float)(cell[i]), pair[i]);
  }
}

/* Gain and bias of every lane of a row, bilinear between the centres of cells (equation 16 of docs/math.md). */
INLINE void photometric_row(__global const float* pairs, int cell_stride, int2 first, int2 last, int tile_x, int y,
                            photometric_rows* rows, lane_float* gain, lane_float* bias) {
  const float row_position = (y - 0.5f * (HF_CELL - 1)) * (1.0f / HF_CELL);
  const int upper = (int)floor(row_position);
  const float t = row_position - upper;
  if (upper != rows->upper_row) {
    if (upper == rows->upper_row + 1) {
#pragma unroll
      for (int i = 0; i < 2 * HF_CHANNELS; ++i) rows->upper[i] = rows->lower[i];
    } else {
      photometric_cells(pairs, cell_stride, first, last, tile_x, upper, rows->upper);
    }
    photometric_cells(pairs, cell_stride, first, last, tile_x, upper + 1, rows->lower);
    rows->upper_row = upper;
  }
#pragma unroll
  for (int c = 0; c < HF_CHANNELS; ++c) {
    const int b = HF_CHANNELS + c;
    gain[c] = fma((lane_float)(t), rows->lower[c] - rows->upper[c], rows->upper[c]);
    bias[c] = fma((lane_float)(t), rows->lower[b] - rows->upper[b], rows->upper[b]);
  }
}

int2 first_cell(hf_rect tiles) { return (int2)(tiles.x, tiles.y) * (HF_TILE / HF_CELL); }
int2 last_cell(hf_rect tiles) {
  return (int2)(tiles.x + tiles.width, tiles.y + tiles.height) * (HF_TILE / HF_CELL) - 1;
}
