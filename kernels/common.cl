/* How work is divided. HF_STRIPS: a work-item walks a whole row or tile with explicit vectors of 16 lanes (CPU
   devices). Otherwise a work-item is one lane and a tile is one work-group of HF_GROUP items (GPUs). */
#pragma OPENCL FP_CONTRACT OFF

#if HF_STRIPS
#define LANES 16
typedef float16 lane_float;
typedef int16 lane_int;
typedef uchar16 lane_uchar;
#define LOAD(p) vload16(0, (p))
#define STORE(v, p) vstore16((v), 0, (p))
#define TO_INT(v) convert_int16(v)
#define TO_INT_DOWN(v) convert_int16_rtn(v)
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
#define LOAD_PIXELS(p) vload16(0, (p))
#define STORE_PIXELS(v, p) vstore16((v), 0, (p))
#else
#define LANES 1
typedef float lane_float;
typedef int lane_int;
typedef uchar lane_uchar;
#define LOAD(p) (*(p))
#define STORE(v, p) (*(p) = (v))
#define TO_INT(v) ((int)(v))
#define TO_INT_DOWN(v) convert_int_rtn(v)
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
#endif

/* select() by a comparison's result: vectors give -1, scalars 1. */
#define CHOOSE(if_false, if_true, mask) select((if_false), (if_true), (mask))

int element(hf_layout layout, int x, int y) { return layout.origin + y * layout.stride + x; }

/* Gain and bias of every lane of a row, bilinear between the centres of cells (equation 16 of docs/math.md). `first` and
   `last` bound the cells that hold values. */
void photometric_row(__global const float* pairs, int cell_stride, int2 first, int2 last, int tile_x, int y,
                     lane_float* gain, lane_float* bias) {
  const float row_position = (y - 0.5f * (HF_CELL - 1)) * (1.0f / HF_CELL);
  const int upper = (int)floor(row_position);
  const float t = row_position - upper;
  __global const float* row0 = pairs + HF_CELL_PAIRS * cell_stride * clamp(upper, first.y, last.y);
  __global const float* row1 = pairs + HF_CELL_PAIRS * cell_stride * clamp(upper + 1, first.y, last.y);
  const lane_float column_position =
      ((lane_float)(TILE_COLUMN) + LANE_INDEX - 0.5f * (HF_CELL - 1)) * (1.0f / HF_CELL);
  for (int c = 0; c < HF_CHANNELS; ++c) gain[c] = bias[c] = (lane_float)(0.0f);
  for (int k = -1; k <= HF_TILE / HF_CELL; ++k) {
    const lane_float weight = fmax((lane_float)(0.0f), 1.0f - fabs(column_position - (float)k));
    const int column = HF_CELL_PAIRS * clamp(tile_x * (HF_TILE / HF_CELL) + k, first.x, last.x);
    const float8 pair = vload8(0, row0 + column) * (1.0f - t) + vload8(0, row1 + column) * t;
    gain[0] = fma(weight, (lane_float)(pair.s0), gain[0]);
    gain[1] = fma(weight, (lane_float)(pair.s1), gain[1]);
    gain[2] = fma(weight, (lane_float)(pair.s2), gain[2]);
    bias[0] = fma(weight, (lane_float)(pair.s3), bias[0]);
    bias[1] = fma(weight, (lane_float)(pair.s4), bias[1]);
    bias[2] = fma(weight, (lane_float)(pair.s5), bias[2]);
  }
}

int2 first_cell(hf_rect tiles) { return (int2)(tiles.x, tiles.y) * (HF_TILE / HF_CELL); }
int2 last_cell(hf_rect tiles) {
  return (int2)(tiles.x + tiles.width, tiles.y + tiles.height) * (HF_TILE / HF_CELL) - 1;
}
