#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/pose.hpp"

/// How objects move: poses at any time, counted in frames, so that what happens within an exposure is known too.
namespace holdfast::simulation {

/// T_camera_object at a time in frames (frame i is at time i).
using PoseAt = std::function<Pose(double frame)>;

/// The same motion through given poses, one a frame, straight on from each to the next; beyond the last it stays there.
PoseAt motion_through(std::vector<Pose> poses);

/// Corners of a mesh's axis-aligned bounding box, object frame, metres.
std::array<Eigen::Vector3d, 8> bounding_corners(const Mesh& mesh);

/// The farthest that any corner's image moves between two poses, pixels.
double corner_motion(const std::array<Eigen::Vector3d, 8>& corners, const Camera& camera, const Pose& T_camera_object_1,
                     const Pose& T_camera_object_2);

enum class MotionStyle {
  smooth,  ///< sums of slow sines in all six degrees of freedom
  sharp,   ///< straight at constant speed, then at once into another direction
  still,   ///< no motion
};

struct MotionOptions {
  MotionStyle style = MotionStyle::smooth;
  /// Pixels a frame that the fastest corner of the bounding box moves by: in 95 % of the frames at most (smooth), or in
  /// all frames but those with a turn exactly (sharp).
  double speed = 4.0;
  double nearest = 0;           ///< of the object's centre, metres; 0: where the object fills the frame's height well
  double farthest = 0;          ///< metres; 0: twice the nearest
  double rotation_range = 0.6;  ///< farthest turn away from the middle orientation about any axis, radians
  int ease = 0;                 ///< sharp: frames to get up to speed from rest, and to rest before a turn; 0: at once
  int turns = 6;                ///< sharp: changes of direction by 90 degrees or more, at least
  double margin = 8;            ///< pixels between the object and the frame's edge, where it fits
  /// R_camera_object that the motion turns about; the default shows the front, top and one side of an object with y up.
  Eigen::Matrix3d orientation = default_orientation();
  /// Not empty: these poses, one a frame, instead of a made motion.
  std::vector<Pose> T_camera_object;

  static Eigen::Matrix3d default_orientation();
};

/// The motion of an object that stays in view. Throws Error(invalid_argument) when options are out of range or no such
/// motion reaches the speed.
PoseAt make_motion(const MotionOptions& options, const Mesh& mesh, const Camera& camera, int frames,
                   std::uint64_t seed);

/// What a motion amounts to, for reports and tests.
struct MotionSummary {
  std::vector<double> corner_speed;  ///< pixels from each frame to the next
  double median_speed = 0;
  double speed_95 = 0;  ///< 95 % of the frames are no faster
  double max_speed = 0;
  int turns = 0;       ///< frames at which the box's centre turns by 90 degrees or more in its way through space
  double nearest = 0;  ///< of the bounding box's centre, metres
  double farthest = 0;
};
MotionSummary summarize_motion(const std::vector<Pose>& poses, const Mesh& mesh, const Camera& camera);

}  // namespace holdfast::simulation
