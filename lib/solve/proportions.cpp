#include "solve/proportions.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

namespace holdfast {
namespace {

/// Frames that are remembered, about, and that it takes to say anything.
constexpr double kMemory = 100;
constexpr int kFewestFrames = 20;
/// Rows that count as one observation, all remembered frames taken together: they share the texture's errors.
constexpr double kRowsPerObservation = 400;
/// How far models usually are from their objects.
constexpr double kUsualStretch = 0.05;
/// Less than this is not worth a word; nor is what is not so many standard deviations away from nothing.
constexpr double kLeastStretch = 0.012, kSure = 6;

}  // namespace

Stretch observed_stretch(const FlowConstraints& constraints, const Camera& level_camera, const Pose& T_camera_view,
                         const Conditioning& conditioning, const Twist& conditioned_step) {
  constexpr int kCellsPerTile = HF_TILE / HF_CELL;
  using Matrix63 = Eigen::Matrix<double, 6, 3>;
  const kernel::hf_rect tiles = constraints.tiles();
  const std::span<const float> all = constraints.tile_sums();
  Matrix6 A = Matrix6::Zero();
  Matrix63 B = Matrix63::Zero();
  Stretch out;
  Twist h = Twist::Zero();
  double squares = 0, rows = 0;
  for (int row = 0; row < tiles.height; ++row) {
    for (int column = 0; column < tiles.width; ++column) {
      const float* sums = all.data() + static_cast<std::size_t>(row * tiles.width + column) * HF_SUM_STRIDE;
      const auto at = [&](int i) { return static_cast<double>(sums[i]); };
      if (at(HF_SUM_ROWS) <= 0) continue;
      // The middle of what is used of the tile.
      Eigen::Vector3d p_camera = Eigen::Vector3d::Zero();
      double pixels = 0;
      for (int cell = 0; cell < kCellsPerTile * kCellsPerTile; ++cell) {
        const int first = HF_SUM_PHOTO + cell * HF_CELL_SUMS;
        const double count = at(first + HF_CELL_PIXELS);
        if (count <= 0) continue;
        const double z = at(first + HF_CELL_DEPTH) / count, half = 0.5 * (HF_CELL - 1);
        const double u = (tiles.x + column) * HF_TILE + (cell % kCellsPerTile) * HF_CELL + half;
        const double v = (tiles.y + row) * HF_TILE + (cell / kCellsPerTile) * HF_CELL + half;
        p_camera +=
            count * z *
            Eigen::Vector3d((u - level_camera.cx) / level_camera.fx, (v - level_camera.cy) / level_camera.fy, 1);
        pixels += count;
      }
      if (pixels <= 0) continue;
      const Eigen::Vector3d p_center = p_camera / pixels - conditioning.p_camera_center;
      Matrix6 tile;
      int n = HF_SUM_A;
      for (int i = 0; i < 6; ++i) {
        for (int j = i; j < 6; ++j) tile(i, j) = tile(j, i) = at(n++);
      }
      Twist score;
      for (int i = 0; i < 6; ++i) score(i) = at(HF_SUM_H + i);
      score -= tile * conditioned_step;
      // Where a stretch of one axis moves this tile, in units of the radius as the rows are.
      const Eigen::Matrix3d R = T_camera_view.linear();
      const Eigen::Matrix3d moved = R * (R.transpose() * p_center).asDiagonal() / conditioning.radius;
      A += tile;
      h += score;
      B += tile.leftCols<3>() * moved;
      out.information += moved.transpose() * tile.topLeftCorner<3, 3>() * moved;
      out.vector += moved.transpose() * score.head<3>();
      squares += at(HF_SUM_WRR);
      rows += at(HF_SUM_ROWS);
    }
  }
  if (rows <= 0) return {};
  const Eigen::LDLT<Matrix6> pose(A + 1e-6 * A.trace() * Matrix6::Identity());
  out.information -= B.transpose() * pose.solve(B);
  out.vector -= B.transpose() * pose.solve(h);
  const double weight = rows / (std::max(1e-9, squares) * kRowsPerObservation);
  return {weight * out.information, weight * out.vector};
}

void Proportions::add(const Stretch& frame) {
  const double keep = 1 - 1 / kMemory;
  sum_.information = keep * sum_.information + frame.information;
  sum_.vector = keep * sum_.vector + frame.vector;
  ++frames_;
}

std::optional<Proportions::Misfit> Proportions::misfit() const {
  if (frames_ < kFewestFrames) return std::nullopt;
  const Eigen::Matrix3d information = sum_.information + Eigen::Matrix3d::Identity() / (kUsualStretch * kUsualStretch);
  const Eigen::Matrix3d covariance = information.inverse();
  const Eigen::Vector3d stretch = covariance * sum_.vector;
  Misfit best;
  double surest = kSure;
  for (const auto& [one, other] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
    const double longer = stretch(one) - stretch(other);
    const double deviation = std::sqrt(covariance(one, one) + covariance(other, other) - 2 * covariance(one, other));
    if (std::abs(longer) < std::max(kLeastStretch, surest * deviation)) continue;
    surest = std::abs(longer) / deviation;
    best = longer < 0 ? Misfit{one, other, -longer} : Misfit{other, one, longer};
  }
  if (surest <= kSure) return std::nullopt;
  return best;
}

}  // namespace holdfast
