#include "tracker/hidden_motions.hpp"

namespace holdfast {
namespace {

/// Share of the contour's information, all directions together, below which it hardly shows a motion that texture
/// does not show at all; of a can's turn it has up to 0.007.
constexpr double kHardly = 0.016;
/// Reliability of texture from which what it does not show is believed not to show.
constexpr double kTelling = 0.5;

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

NormalEquations without_turns(NormalEquations outline, const std::vector<Twist>& turns) {
  for (const Twist& turn : turns) {
    // No row answers to the turn: what it seems to tell of it is that facets and pixels are off their surface.
    Twist amount = turn;
    amount.head<3>().setZero();
    const Twist told = outline.A * turn;
    outline.h -= amount * turn.dot(outline.h);
    outline.A += amount * turn.dot(told) * amount.transpose() - amount * told.transpose() - told * amount.transpose();
  }
  return outline;
}

}  // namespace holdfast
