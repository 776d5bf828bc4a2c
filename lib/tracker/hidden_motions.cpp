#include "tracker/hidden_motions.hpp"

#include <cmath>

namespace holdfast {
namespace {

/// Reliability of texture from which what it does not show is believed not to show.
constexpr double kTelling = 0.5;
/// Cosine between a motion that does not show and a round shape's turns from which it is one of them: print has errors.
constexpr double kThatTurn = 0.7;

/// Takes away what the equations tell of a motion, alone and together with others.
void forget(const Twist& motion, NormalEquations& equations) {
  const Twist told = equations.A * motion;
  const double information = motion.dot(told);
  if (information <= 1e-9 * equations.A.trace()) return;  // nothing but rounding
  equations.h -= told * (motion.dot(equations.h) / information);
  equations.A -= told * told.transpose() / information;
}

/// Cosine between a motion of unit length and the nearest turn that these add up to; they are at right angles.
double cosine(const Twist& motion, const std::vector<Twist>& turns) {
  double square = 0;
  for (const Twist& turn : turns) square += std::pow(motion.dot(turn.normalized()), 2);
  return std::sqrt(square);
}

}  // namespace

NormalEquations without_hidden(NormalEquations outline, const TextureTerms& texture, const Pose& T_drawn,
                               const std::vector<Twist>& turns) {
  if (texture.reliability < kTelling) return outline;  // texture that passes by chance shows nothing of any motion
  const Matrix6 B = to_camera_axes(T_drawn);
  for (int i = 0; i < texture.unobservable.count; ++i) {
    const Twist motion = (B.transpose() * texture.unobservable.motions.col(i)).normalized();
    if (cosine(motion, turns) > kThatTurn) forget(motion, outline);
  }
  return outline;
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
