#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/frame_result.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/pose.hpp"

namespace holdfast::app {

/// Another way in which a pose may have been meant.
struct PoseReading {
  std::string name;  ///< "in OpenGL's axes (...)"
  Pose T_camera_object = Pose::Identity();
};

/// The pose that the numbers mean in other programs' conventions: OpenGL's axes, whole or half converted, camera to
/// object, a rotation by columns, rvec and tvec exchanged, a quaternion with w first, a model with another axis up.
std::vector<PoseReading> other_readings(const Pose& T_camera_object);

/// Throws Error(pose), with what may have been meant, where the object is behind the camera or out of the picture.
void require_in_view(const Mesh& mesh, const Camera& camera, const Pose& T_camera_object);

/// What is wrong where the first frame is lost and no other reading of the pose finds the object.
std::string lost_start(const FrameResult& first);

/// The first other reading of a given pose under which `is_held` finds the object: asked where the first frame is lost
/// or unlike under the pose as it stands. `by_texture`: what holds it is its texture, not the outline alone.
std::optional<std::string> pose_hint(const Pose& T_camera_object, bool by_texture,
                                     const std::function<bool(const Pose&)>& is_held);

/// The doubt where the first frame shows the outline of a textured model and not its print.
std::string held_by_outline();

}  // namespace holdfast::app
