#include "texture/noise_information.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

namespace holdfast {
namespace {

/// Times what noise makes of itself, as noise_information() has it, that A must be to show a motion.
constexpr double kShown = 0.3;
/// What pixels and blur make of a gradient's direction: share of its square that is across it.
constexpr double kAstray = 0.02;

/// What the gradients of a tile's rows are together, weighted squares, by how the tile moves across the line of sight.
double gradient_square(const float* tile, const Camera& camera, double radius) {
  double pixels = 0, depth = 0;
  for (int c = 0; c < HF_TILE / HF_CELL * (HF_TILE / HF_CELL); ++c) {
    pixels += tile[HF_SUM_PHOTO + c * HF_CELL_SUMS + HF_CELL_PIXELS];
    depth += tile[HF_SUM_PHOTO + c * HF_CELL_SUMS + HF_CELL_DEPTH];
  }
  const double z = depth / std::max(1.0, pixels), x = z / (radius * camera.fx), y = z / (radius * camera.fy);
  return tile[HF_SUM_A] * x * x + tile[HF_SUM_A + 6] * y * y;
}

}  // namespace

Matrix6 noise_information(std::span<const float> tile_sums, const kernel::hf_rect& tiles, const Camera& camera,
                          const Conditioning& conditioning, double noise_square, int channels) {
  constexpr int kAcross = HF_TILE / HF_CELL;
  Matrix6 information = Matrix6::Zero();
  const float* tile = tile_sums.data();
  for (int row = 0; row < tiles.height; ++row) {
    for (int column = 0; column < tiles.width; ++column, tile += HF_SUM_STRIDE) {
      if (tile[HF_SUM_ROWS] <= 0.0f) continue;
      const double gradients = gradient_square(tile, camera, conditioning.radius);
      const double square = noise_square + kAstray * gradients / std::max(1e-12, static_cast<double>(tile[HF_SUM_W]));
      for (int c = 0; c < kAcross * kAcross; ++c) {
        const float* cell = tile + HF_SUM_PHOTO + c * HF_CELL_SUMS;
        const double pixels = cell[HF_CELL_PIXELS];
        if (pixels <= 0) continue;
        double weight = 0;
        for (int channel = 0; channel < channels; ++channel) weight += cell[channel * HF_PHOTO];
        const double z = cell[HF_CELL_DEPTH] / pixels;
        const double x = ((tiles.x + column) * kAcross + c % kAcross) * HF_CELL + 0.5 * (HF_CELL - 1);
        const double y = ((tiles.y + row) * kAcross + c / kAcross) * HF_CELL + 0.5 * (HF_CELL - 1);
        const Eigen::Vector3d p_camera(z * (x - camera.cx) / camera.fx, z * (y - camera.cy) / camera.fy, z);
        const Eigen::Vector3d arm = p_camera - conditioning.p_camera_center;
        // How the pixel moves with the conditioned twist: equations 1 and 11b.
        Eigen::Matrix<double, 2, 3> projection;
        projection << camera.fx / z, 0, -camera.fx * p_camera.x() / (z * z),  //
            0, camera.fy / z, -camera.fy * p_camera.y() / (z * z);
        Eigen::Matrix<double, 2, 6> motion;
        motion.leftCols<3>() = conditioning.radius * projection;
        for (int i = 0; i < 3; ++i) motion.col(3 + i) = projection * Eigen::Vector3d::Unit(i).cross(arm);
        information += square * weight * motion.transpose() * motion;
      }
    }
  }
  return information;
}

UnobservableMotions unobservable_motions(const Matrix6& A, const Matrix6& noise) {
  UnobservableMotions result;
  if (noise.trace() <= 0 || Eigen::LLT<Matrix6>(A - kShown * noise).info() == Eigen::Success) return result;
  // Of a few pixels in line noise would not show everything either.
  const Matrix6 least = noise + 1e-9 * noise.trace() * Matrix6::Identity();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix6> solver(A, least);
  for (int i = 0; i < 6 && solver.eigenvalues()(i) < kShown; ++i) {
    const Twist hidden = solver.eigenvectors().col(i);  // of length 1 in terms of `least`
    result.observable -= hidden * (least * hidden).transpose();
    result.motions.col(result.count++) = hidden;
  }
  return result;
}

}  // namespace holdfast
