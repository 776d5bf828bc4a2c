#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "holdfast/camera.hpp"
#include "holdfast/pose.hpp"
#include "solve/solver.hpp"
#include "texture/flow_constraints.hpp"

namespace holdfast {

/// What one frame says of how the object is stretched along its own axes beside its model: normal equations with the
/// pose eliminated (equation 22 of docs/math.md). Stretch of all axes alike is no information: distance does the same.
struct Stretch {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d vector = Eigen::Vector3d::Zero();
};

/// Of a level's tiles, on the view of this pose, and the step that was solved for last.
Stretch observed_stretch(const FlowConstraints& constraints, const Camera& level_camera, const Pose& T_camera_view,
                         const Conditioning& conditioning, const Twist& conditioned_step);

/// Whether the model has the object's proportions, from many frames.
class Proportions {
 public:
  void clear() { *this = {}; }
  void add(const Stretch& frame);

  /// The model is too large along one of the object's axes, or too small along another.
  struct Misfit {
    int large = 0;
    int small = 0;
    double share = 0;  ///< by which the two lengths are out of proportion, at least
  };
  /// The two axes that are most surely out of proportion, if any are.
  std::optional<Misfit> misfit() const;

 private:
  Stretch sum_;
  int frames_ = 0;
};

}  // namespace holdfast
