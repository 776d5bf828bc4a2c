#include "texture/score_covariance.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace holdfast {
namespace {

/// Blocks that an object is taken to consist of, as far as errors go, and tiles on a side that make one at least: 48
/// pixels share the blur's, texture's and codec's errors, and larger objects have larger parts in common.
constexpr double kBlocks = 6;
constexpr int kLeastSide = 3;
/// Blocks that are taken to say the same in every direction, beside those there are.
constexpr double kAlike = 3;
/// How far a block may decide alone, so that one that holds all there is says something finite.
constexpr double kAlone = 0.1;
/// By how much the averaging of light may differ, standard deviation, square pixels; calibrated on simulated objects
/// (`make robustness`, covariance-made-for).
constexpr double kLightDeviation = 0.1;

/// Pixels that a whole view is drawn off, standard deviation; calibrated likewise, on frames without noise too.
constexpr double kDrawnDeviation = 1.0 / 512;

}  // namespace

void tile_equations(std::span<const float> tile_sums, const kernel::hf_rect& tiles,
                    std::vector<TileEquations>& equations) {
  equations.assign(static_cast<std::size_t>(tiles.width) * static_cast<std::size_t>(tiles.height), {});
  const float* sums = tile_sums.data();
  for (TileEquations& tile : equations) {
    if (sums[HF_SUM_ROWS] > 0.0f) {
      tile.informative = true;
      std::size_t n = HF_SUM_A;
      for (int i = 0; i < 6; ++i) {
        for (int j = i; j < 6; ++j) tile.A(i, j) = tile.A(j, i) = static_cast<double>(sums[n++]);
        tile.h(i) = static_cast<double>(sums[HF_SUM_H + i]);
      }
    }
    sums += HF_SUM_STRIDE;
  }
}

Matrix6 score_covariance(std::span<const TileEquations> tiles, int columns, const Twist& conditioned_step,
                         const Matrix6& A, std::vector<TileEquations>& strip) {
  const int rows = static_cast<int>(tiles.size()) / columns;
  const Matrix6 all = (1 + kAlone) * A;
  Matrix6 blocks = Matrix6::Zero();
  Twist to_dark = Twist::Zero();
  double informative_tiles = 0;
  for (const TileEquations& tile : tiles) {
    to_dark += tile.to_dark;
    informative_tiles += tile.informative;
  }
  const int side = std::max(kLeastSide, static_cast<int>(std::lround(std::sqrt(informative_tiles / kBlocks))));
  const auto add = [](const TileEquations& tile, TileEquations& sum) {
    if (!tile.informative) return;
    sum.informative = true;
    sum.A += tile.A;
    sum.h += tile.h;
  };
  // Every block, one overlapping the next: what neighbours have in common adds up in it.
  for (int row = 1 - side; row < rows; ++row) {
    strip.assign(static_cast<std::size_t>(columns), {});  // the blocks' rows, summed column by column
    for (int y = std::max(0, row); y < std::min(rows, row + side); ++y) {
      for (int x = 0; x < columns; ++x) {
        add(tiles[static_cast<std::size_t>(y * columns + x)], strip[static_cast<std::size_t>(x)]);
      }
    }
    for (int column = 1 - side; column < columns; ++column) {
      TileEquations block;
      for (int x = std::max(0, column); x < std::min(columns, column + side); ++x) {
        add(strip[static_cast<std::size_t>(x)], block);
      }
      if (!block.informative) continue;
      Twist score = block.h - block.A * conditioned_step;
      // The block helped to find the solution that it is compared with; this would be its score without it.
      const Eigen::LLT<Matrix6> others(all - block.A);
      if (others.info() == Eigen::Success) score = all * others.solve(score);
      blocks += score * score.transpose();
    }
  }
  blocks /= side * side;
  // What few blocks say of a single direction is much by chance; how they spread in all of them together is less so.
  const double count = informative_tiles / (side * side), alike = A.llt().solve(blocks).trace() / 6;
  return (count * blocks + kAlike * alike * A) / (count + kAlike) +
         kLightDeviation * kLightDeviation * to_dark * to_dark.transpose();
}

double robust_curvature(double mean_weight, double freedom) {
  // Residuals much smaller than the scale all weigh (freedom + 1) / freedom.
  const double fits = std::clamp(freedom + 1 - freedom * mean_weight, 0.0, 1.0);
  return 1 - 2 / (freedom + 3) * fits;
}

Matrix6 drawing_covariance(const Conditioning& conditioning, double focal_length) {
  const Eigen::Vector3d& p = conditioning.p_camera_center;
  const double deviation = kDrawnDeviation * p.norm() / (focal_length * conditioning.radius);
  const Eigen::Vector3d ray = p.normalized();
  Matrix6 covariance = Matrix6::Zero();
  covariance.topLeftCorner<3, 3>() = deviation * deviation * (Eigen::Matrix3d::Identity() - ray * ray.transpose());
  return covariance;
}

}  // namespace holdfast
