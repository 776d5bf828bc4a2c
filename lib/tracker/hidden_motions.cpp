#include "tracker/hidden_motions.hpp"

namespace holdfast {

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
