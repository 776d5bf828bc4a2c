#include "texture/photometry.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace holdfast {
namespace {

constexpr int kCellsPerTile = HF_TILE / HF_CELL;

/// What the object's pair weighs against a cell's own pixels: as much as this many pixels of this contrast.
constexpr double kPriorPixels = 20;
constexpr double kPriorVariance = 0.05 * 0.05;
/// How far a block's pair may be from its present value.
constexpr double kGainDeviation = 0.1, kBiasDeviation = 0.05;
constexpr double kLeastGain = 0.1, kMostGain = 5.0;
/// Below this intensity a ratio of light says nothing.
constexpr double kDarkest = 0.05;

struct Moments {
  double w = 0, v = 0, i = 0, vv = 0, ii = 0, vi = 0;

  void add(const float* sums) {
    w += static_cast<double>(sums[0]);
    v += static_cast<double>(sums[1]);
    i += static_cast<double>(sums[2]);
    vv += static_cast<double>(sums[3]);
    ii += static_cast<double>(sums[4]);
    vi += static_cast<double>(sums[5]);
  }
  double centered_vv() const { return w > 0 ? std::max(0.0, vv - v * v / w) : 0; }
  double centered_ii() const { return w > 0 ? std::max(0.0, ii - i * i / w) : 0; }
  double centered_vi() const { return w > 0 ? vi - v * i / w : 0; }

  /// Moments, not regression: a misaligned view has the right spread but not the right correlation.
  double gain(double expected) const {
    const double prior = kPriorPixels * kPriorVariance;
    return std::clamp(std::sqrt((centered_ii() + prior * expected * expected) / (centered_vv() + prior)), kLeastGain,
                      kMostGain);
  }
};

std::size_t count(const kernel::hf_rect& tiles) { return static_cast<std::size_t>(tiles.width * tiles.height); }

const float* cell_sums(const FlowConstraints& constraints, std::size_t tile, int cell) {
  return constraints.tile_sums().data() + tile * HF_SUM_STRIDE + HF_SUM_PHOTO +
         static_cast<std::size_t>(cell * HF_CELL_SUMS);
}

using Matrix62 = Eigen::Matrix<double, 6, 2>;

/// What ties a tile's pose to its light, a channel each (equation 17).
struct TileLight {
  std::array<Matrix62, HF_CHANNELS> B;
  std::array<Eigen::Matrix2d, HF_CHANNELS> C;
  std::array<Eigen::Vector2d, HF_CHANNELS> d;
  std::array<Twist, HF_CHANNELS> to_dark;
  bool any = false;

  /// `edges`: to_dark is wanted too.
  TileLight(const FlowConstraints& constraints, const kernel::hf_constraints& k, const ConstraintSums& sums,
            std::size_t tile, bool edges) {
    const kernel::hf_rect tiles = constraints.tiles();
    const int column = static_cast<int>(tile) % tiles.width, row = static_cast<int>(tile) / tiles.width;
    const double variance = std::max(sums.weighted_square / sums.rows, 1e-6);
    const double prior_gain = variance / (kGainDeviation * kGainDeviation);
    const double prior_bias = variance / (kBiasDeviation * kBiasDeviation);
    const Eigen::Vector3d center(k.center[0], k.center[1], k.center[2]);
    const double radius = k.radius, fx = k.fx, fy = k.fy, cx = k.cx, cy = k.cy;
    for (std::size_t c = 0; c < HF_CHANNELS; ++c) {
      B[c].setZero();
      C[c] << prior_gain, 0, 0, prior_bias;
      d[c].setZero();
      to_dark[c].setZero();
    }
    for (int cell = 0; cell < kCellsPerTile * kCellsPerTile; ++cell) {
      const float* s = cell_sums(constraints, tile, cell);
      if (s[HF_CELL_PIXELS] <= 0.0f) continue;
      any = true;
      // The 2x6 geometry at the cell's middle and mean depth (as the kernel's rows).
      const double z = static_cast<double>(s[HF_CELL_DEPTH]) / static_cast<double>(s[HF_CELL_PIXELS]);
      const double half = 0.5 * (HF_CELL - 1);
      const double x = ((tiles.x + column) * HF_TILE + (cell % kCellsPerTile) * HF_CELL + half - cx) / fx;
      const double y = ((tiles.y + row) * HF_TILE + (cell / kCellsPerTile) * HF_CELL + half - cy) / fy;
      const Eigen::Vector3d arm = Eigen::Vector3d(x * z, y * z, z) - center;
      const Eigen::Vector3d gu(fx / z, 0, -x * fx / z), gv(0, fy / z, -y * fy / z);
      Matrix62 L;
      L.col(0) << radius * gu, arm.cross(gu);
      L.col(1) << radius * gv, arm.cross(gv);
      for (std::size_t c = 0; c < HF_CHANNELS; ++c) {
        const float* m = s + c * HF_PHOTO;
        const auto value = [&](int i) { return static_cast<double>(m[i]); };
        Eigen::Matrix2d gradients;  // columns: with V, with 1
        gradients << value(10), value(8), value(11), value(9);
        const Matrix62 rows = L * gradients;
        B[c] += rows;
        C[c](0, 0) += value(3);
        C[c](0, 1) += value(1);
        C[c](1, 0) += value(1);
        C[c](1, 1) += value(0);
        d[c] += Eigen::Vector2d(value(7), value(6));
        if (!edges || value(0) <= 0) continue;
        const double mean = value(1) / value(0), spread = std::max(0.0, value(3) / value(0) - mean * mean);
        to_dark[c] += spread / std::max(mean, kDarkest) * rows.col(1);
      }
    }
  }

  /// From a tile's equations, or from a sum that they are part of.
  void eliminate(Matrix6& A, Twist& h) const {
    for (std::size_t c = 0; any && c < HF_CHANNELS; ++c) {
      const Matrix62 BC = B[c] * C[c].inverse();
      A -= BC * B[c].transpose();
      h -= BC * d[c];
    }
  }
};

}  // namespace

Matrix6 left_beside_light(const Matrix6& A, const Matrix6& A_rows) {
  if (Eigen::LLT<Matrix6>(A).info() == Eigen::Success) return Matrix6::Identity();
  // Sums of floats are good to 1e-7.
  const Matrix6 rows = A_rows + 1e-7 * A_rows.trace() * Matrix6::Identity();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6> eigen(A, rows);
  Matrix6 motions = eigen.eigenvectors();
  for (int i = 0; i < 6; ++i) {
    if (eigen.eigenvalues()(i) <= 0) motions.col(i).setZero();
  }
  return motions * motions.transpose() * rows;
}

Photometry::Photometry(const Device::Impl& device, const std::vector<Level>& levels, bool enabled)
    : device_(device), levels_(levels), enabled_(enabled) {
  for (const Level& level : levels) {
    LevelCells cells;
    const std::size_t count = static_cast<std::size_t>(level.cells_x()) * static_cast<std::size_t>(level.cells_y());
    cells.pairs.resize(count * HF_CELL_PAIRS);
    cells.buffer = device.zeroed_buffer(cells.pairs.size() * sizeof(float));
    cells_.push_back(std::move(cells));
    moments_.resize(std::max(moments_.size(), count * HF_CELL_SUMS));
  }
  blurred_.resize(moments_.size());
  for (std::size_t l = 0; l < levels.size(); ++l) {
    start_level(static_cast<int>(l), {0, 0, levels[l].tiles_x(), levels[l].tiles_y()});
  }
}

void Photometry::forget_cells() {
  for (LevelCells& cells : cells_) cells.tiles = {};
}

bool Photometry::has(int level, int cell_x, int cell_y) const {
  const kernel::hf_rect& tiles = cells_[static_cast<std::size_t>(level)].tiles;
  const int x = cell_x / kCellsPerTile - tiles.x, y = cell_y / kCellsPerTile - tiles.y;
  return x >= 0 && x < tiles.width && y >= 0 && y < tiles.height;
}

void Photometry::start_level(int level, const kernel::hf_rect& tiles, int from_level) {
  const auto l = static_cast<std::size_t>(level);
  const int stride = levels_[l].cells_x();
  cells_[l].tiles = tiles;
  for (int cy = tiles.y * kCellsPerTile; cy < (tiles.y + tiles.height) * kCellsPerTile; ++cy) {
    for (int cx = tiles.x * kCellsPerTile; cx < (tiles.x + tiles.width) * kCellsPerTile; ++cx) {
      float* pair = cells_[l].pairs.data() + static_cast<std::size_t>(HF_CELL_PAIRS * (cy * stride + cx));
      const int down = from_level - level;
      if (from_level >= 0 && has(from_level, cx >> down, cy >> down)) {
        const auto from = static_cast<std::size_t>(from_level);
        const float* coarse =
            cells_[from].pairs.data() +
            static_cast<std::size_t>(HF_CELL_PAIRS * ((cy >> down) * levels_[from].cells_x() + (cx >> down)));
        std::copy(coarse, coarse + 2 * HF_CHANNELS, pair);
        continue;
      }
      for (std::size_t c = 0; c < HF_CHANNELS; ++c) {
        pair[c] = static_cast<float>(gain_[c]);
        pair[HF_CHANNELS + c] = static_cast<float>(bias_[c]);
      }
    }
  }
}

void Photometry::blur_moments(int columns, int rows) {
  // Binomial (1 2 1)/4 both ways: sums of neighbours count for less the farther they are.
  const auto at = [&](std::vector<float>& values, int column, int row) {
    return values.data() + static_cast<std::size_t>(row * columns + column) * kMoments;
  };
  const auto pass = [&](std::vector<float>& from, std::vector<float>& to, int step_x, int step_y) {
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) {
        const float* center = at(from, column, row);
        const bool has_before = column - step_x >= 0 && row - step_y >= 0;
        const bool has_after = column + step_x < columns && row + step_y < rows;
        const float* before = has_before ? at(from, column - step_x, row - step_y) : nullptr;
        const float* after = has_after ? at(from, column + step_x, row + step_y) : nullptr;
        float* out = at(to, column, row);
        for (std::size_t i = 0; i < kMoments; ++i) {
          out[i] = 0.5f * center[i] + 0.25f * ((before ? before[i] : 0.0f) + (after ? after[i] : 0.0f));
        }
      }
    }
  };
  pass(moments_, blurred_, 1, 0);
  pass(blurred_, moments_, 0, 1);
}

void Photometry::update(int level, const FlowConstraints& constraints) {
  if (!enabled_) return;
  const auto l = static_cast<std::size_t>(level);
  const kernel::hf_rect tiles = constraints.tiles();
  const int columns = tiles.width * kCellsPerTile, rows = tiles.height * kCellsPerTile;
  std::array<Moments, HF_CHANNELS> object;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const auto tile = static_cast<std::size_t>((row / kCellsPerTile) * tiles.width + column / kCellsPerTile);
      const float* sums = cell_sums(constraints, tile, (row % kCellsPerTile) * kCellsPerTile + column % kCellsPerTile);
      float* moments = moments_.data() + static_cast<std::size_t>(row * columns + column) * kMoments;
      for (std::size_t c = 0; c < HF_CHANNELS; ++c) {
        std::copy(sums + c * HF_PHOTO, sums + c * HF_PHOTO + 6, moments + c * 6);
        object[c].add(sums + c * HF_PHOTO);
      }
    }
  }
  for (std::size_t c = 0; c < HF_CHANNELS; ++c) {
    if (object[c].w < kPriorPixels) continue;
    gain_[c] = object[c].gain(gain_[c]);
    bias_[c] = (object[c].i - gain_[c] * object[c].v) / object[c].w;
  }
  blur_moments(columns, rows);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int cy = tiles.y * kCellsPerTile + row, cx = tiles.x * kCellsPerTile + column;
      float* pair = cells_[l].pairs.data() + static_cast<std::size_t>(HF_CELL_PAIRS * (cy * levels_[l].cells_x() + cx));
      for (std::size_t c = 0; c < HF_CHANNELS; ++c) {
        Moments near;
        near.add(moments_.data() + static_cast<std::size_t>(row * columns + column) * kMoments + c * 6);
        double gain = gain_[c], bias = bias_[c];
        if (near.w > 0.5) {
          gain = near.gain(gain_[c]);
          bias = (near.i - gain * near.v) / near.w;
        }
        pair[c] = static_cast<float>(gain);
        pair[HF_CHANNELS + c] = static_cast<float>(bias);
      }
    }
  }
}

void Photometry::eliminate(const FlowConstraints& constraints, const kernel::hf_constraints& k,
                           ConstraintSums& sums) const {
  if (!eliminates() || sums.rows <= 0) return;
  for (std::size_t i = 0; i < count(constraints.tiles()); ++i) {
    TileLight(constraints, k, sums, i, false).eliminate(sums.A, sums.h);
  }
  sums.beside_light = left_beside_light(sums.A, sums.A_rows);
  if (sums.beside_light.isIdentity(0)) return;
  sums.A = (sums.beside_light.transpose() * sums.A * sums.beside_light).eval();
  sums.h = (sums.beside_light.transpose() * sums.h).eval();
}

void Photometry::eliminate(const FlowConstraints& constraints, const kernel::hf_constraints& k,
                           const ConstraintSums& sums, std::span<TileEquations> equations) const {
  if (!eliminates() || sums.rows <= 0) return;
  for (std::size_t i = 0; i < equations.size(); ++i) {
    TileEquations& tile = equations[i];
    const TileLight light(constraints, k, sums, i, true);
    if (!light.any || !tile.informative) continue;
    light.eliminate(tile.A, tile.h);
    for (std::size_t c = 0; c < HF_CHANNELS; ++c) tile.to_dark += gain_[c] * light.to_dark[c];
  }
  if (sums.beside_light.isIdentity(0)) return;
  for (TileEquations& tile : equations) {
    tile.A = (sums.beside_light.transpose() * tile.A * sums.beside_light).eval();
    tile.h = (sums.beside_light.transpose() * tile.h).eval();
    tile.to_dark = (sums.beside_light.transpose() * tile.to_dark).eval();
  }
}

void Photometry::enqueue_upload(int level, const kernel::hf_rect& tiles) {
  const auto l = static_cast<std::size_t>(level);
  const auto row = static_cast<std::size_t>(levels_[l].cells_x()) * HF_CELL_PAIRS;
  const std::size_t first = static_cast<std::size_t>(tiles.y * kCellsPerTile) * row;
  const std::size_t count = static_cast<std::size_t>(tiles.height * kCellsPerTile) * row;
  if (count == 0) return;
  device_.queue.enqueueWriteBuffer(cells_[l].buffer, CL_FALSE, first * sizeof(float), count * sizeof(float),
                                   cells_[l].pairs.data() + first);
}

double Photometry::correlation(const FlowConstraints& constraints) {
  double vv = 0, ii = 0, vi = 0;
  for (std::size_t tile = 0; tile < count(constraints.tiles()); ++tile) {
    for (int cell = 0; cell < kCellsPerTile * kCellsPerTile; ++cell) {
      for (std::size_t c = 0; c < HF_CHANNELS; ++c) {
        Moments moments;
        moments.add(cell_sums(constraints, tile, cell) + c * HF_PHOTO);
        vv += moments.centered_vv();
        ii += moments.centered_ii();
        vi += moments.centered_vi();
      }
    }
  }
  // Where hardly a pixel is used, what is left of the sums is rounding.
  return vv > 0 && ii > 0 ? std::clamp(vi / std::sqrt(vv * ii), -1.0, 1.0) : 0;
}

}  // namespace holdfast
