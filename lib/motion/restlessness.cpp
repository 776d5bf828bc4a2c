#include "motion/restlessness.hpp"

#include <algorithm>

namespace holdfast {

void Restlessness::MeanSquare::add(const Matrix6& square) {
  weight = std::min(weight + 1, kMemory);
  value += (square - value) / weight;
}

void Restlessness::add(const Twist& conditioned_deviation) {
  if (followed_ > 0) smooth_.add(conditioned_deviation * conditioned_deviation.transpose());
  if (followed_ > 1) {
    // Of a sudden change of velocity 1, -2 and 1 times it: a sixth of the squares. Of smooth motion next to nothing.
    const Twist bend = conditioned_deviation - 2 * last_ + before_last_;
    sudden_.add(bend * bend.transpose() / 6);
  }
  before_last_ = last_;
  last_ = conditioned_deviation;
  followed_ = std::min(followed_ + 1, 2);
}

Matrix6 Restlessness::within(double exposure) const {
  const double at_once = exposure / 8, gradually = exposure * exposure / 24;
  return at_once * at_once * sudden_.value + gradually * gradually * smooth_.value;
}

}  // namespace holdfast
