#include "recovery/symmetries.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "base/turns.hpp"

namespace holdfast {
namespace {

/// Ratio of the spreads along two axes below which neither stands out: the axes as modelled are taken then.
constexpr double kRound = 1.05;
constexpr double kQuarter = 1.5707963267948966;

}  // namespace

std::vector<Pose> possible_symmetries(const Mesh& mesh) {
  const Eigen::Vector3d center = mesh.center().cast<double>();
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3f& position : mesh.positions) {
    const Eigen::Vector3d arm = position.cast<double>() - center;
    spread += arm * arm.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  const Eigen::Vector3d& size = solver.eigenvalues();
  const bool round = size(1) < kRound * size(0) || size(2) < kRound * size(1);
  const Eigen::Matrix3d axes = round ? Eigen::Matrix3d::Identity().eval() : solver.eigenvectors();
  std::vector<Pose> turns;
  for (int axis = 0; axis < 3; ++axis) {
    for (int quarters = 1; quarters <= 3; ++quarters) {
      const Eigen::AngleAxisd turn(quarters * kQuarter, axes.col(axis));
      turns.push_back(anchored(turn.toRotationMatrix(), center, center));
    }
  }
  return turns;
}

}  // namespace holdfast
