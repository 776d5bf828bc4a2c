#include "tracker/hidden_motions.hpp"

#include <algorithm>
#include <cmath>

namespace holdfast {
namespace {

/// Reliability of texture from which what it does not show is believed not to show.
constexpr double kTelling = 0.5;
/// Cosine between a motion that does not show and a round shape's turn from which it is that turn: print has errors.
constexpr double kThatTurn = 0.7;

/// Takes away what the equations tell of a motion, alone and together with others.
void forget(const Twist& motion, NormalEquations& equations) {
  const Twist told = equations.A * motion;
  const double information = motion.dot(told);
  if (information <= 0) return;
  equations.h -= told * (motion.dot(equations.h) / information);
  equations.A -= told * told.transpose() / information;
}

}  // namespace

NormalEquations without_hidden(NormalEquations outline, const TextureTerms& texture, const Pose& T_drawn,
                               const std::vector<Twist>& turns) {
  if (texture.reliability < kTelling) return outline;  // texture that passes by chance shows nothing of any motion
  const Matrix6 B = to_camera_axes(T_drawn);
  for (int i = 0; i < texture.unobservable.count; ++i) {
    const Twist motion = (B.transpose() * texture.unobservable.motions.col(i)).normalized();
    const auto that = [&](const Twist& turn) { return std::abs(motion.dot(turn.normalized())) > kThatTurn; };
    if (std::ranges::any_of(turns, that)) forget(motion, outline);
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
