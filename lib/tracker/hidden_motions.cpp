#include "tracker/hidden_motions.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace holdfast {
namespace {

/// Share of the contour's information, all directions together, below which it hardly shows a motion that texture
/// does not show at all; of a can's turn it has up to 0.007.
constexpr double kHardly = 0.016;
/// Reliability of texture from which what it does not show is believed not to show.
constexpr double kTelling = 0.5;
/// Share of the outline's information, all motions together, below which it does not show a turn: of the turn of cans,
/// bottles and tubes about their axis it has 0.0001 to 0.0016, of any turn of boxes, loaves and figures 0.0014 or more.
constexpr double kFaint = 0.0018;

/// Takes away what the equations tell of a motion, alone and together with others.
void forget(const Twist& motion, NormalEquations& equations) {
  const Twist told = equations.A * motion;
  const double information = motion.dot(told);
  if (information <= 0) return;
  equations.h -= told * (motion.dot(equations.h) / information);
  equations.A -= told * told.transpose() / information;
}

}  // namespace

NormalEquations without_hidden(NormalEquations contour, const TextureTerms& texture, const Pose& T_drawn) {
  const Matrix6 B = to_camera_axes(T_drawn);
  if (texture.reliability < kTelling) return contour;  // texture that passes by chance shows nothing of any motion
  for (int i = 0; i < texture.unobservable.count; ++i) {
    const Twist motion = (B.transpose() * texture.unobservable.motions.col(i)).normalized();
    if (motion.dot(contour.A * motion) <= kHardly * contour.A.trace()) forget(motion, contour);
  }
  return contour;
}

NormalEquations without_faint_turns(NormalEquations outline) {
  const double trace = outline.A.trace();
  if (trace <= 0) return outline;
  const Eigen::Matrix3d places = outline.A.topLeftCorner<3, 3>() + 1e-9 * trace * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d along = -places.ldlt().solve(outline.A.topRightCorner<3, 3>());
  const Eigen::Matrix3d turns = outline.A.bottomRightCorner<3, 3>() + outline.A.bottomLeftCorner<3, 3>() * along;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(turns);
  for (int i = 0; i < 3; ++i) {
    if (solver.eigenvalues()(i) > kFaint * trace) break;
    Twist motion;
    motion << along * solver.eigenvectors().col(i), solver.eigenvectors().col(i);
    forget(motion, outline);
  }
  return outline;
}

}  // namespace holdfast
