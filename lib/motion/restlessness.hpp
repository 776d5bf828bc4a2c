#pragma once

#include "holdfast/pose.hpp"

namespace holdfast {

/// How an object strays from constant velocity from frame to frame. While the shutter is open it may change its
/// velocity; then the middle of the blurred picture is not where the object was in the middle of the exposure.
class Restlessness {
 public:
  /// The object came to be so far from where constant velocity had put it.
  void add(const Twist& conditioned_deviation);
  /// It was lost meanwhile: the next deviation has none before it.
  void interrupt() { followed_ = 0; }
  /// Covariance that this adds to a pose seen with this exposure, a share of the time between frames (equation 12a).
  Matrix6 within(double exposure) const;

 private:
  /// Object radii and radians, until it is known, and how many frames that is worth.
  static constexpr double kExpected = 0.05, kExpectedFrames = 0.02;
  static constexpr double kMemory = 50;  ///< frames

  /// A running mean of squares.
  struct MeanSquare {
    Matrix6 value;
    double weight;
    void add(const Matrix6& square);
  };
  /// Accelerations, and what is not smooth in them, a frame.
  MeanSquare smooth_{kExpected * kExpected * Matrix6::Identity(), kExpectedFrames}, sudden_ = smooth_;
  Twist last_ = Twist::Zero(), before_last_ = Twist::Zero();
  int followed_ = 0;  ///< deviations in a row, up to 2
};

}  // namespace holdfast
