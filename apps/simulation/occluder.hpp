#pragma once

#include <Eigen/Core>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/pose.hpp"
#include "simulation/motion.hpp"
#include "simulation/rasterizer.hpp"

/// Things that pass in front of the object.
namespace holdfast::simulation {

enum class OccluderKind {
  bar,   ///< an upright bar of one colour that sweeps across the frame
  cube,  ///< a lettered cube that passes several times, covers most of the object near the end, and leaves
  mesh,  ///< any mesh along given poses
};

struct OccluderOptions {
  OccluderKind kind = OccluderKind::bar;
  Finish finish;

  // bar
  double bar_width = 60;       ///< pixels
  int sweeps = 2;              ///< passes over the frame, there and back; 0: stands still
  double bar_column = 0;       ///< sweeps 0: pixel column of its middle
  double bar_distance = 0.85;  ///< share of the smallest distance of the object's surface
  Eigen::Vector3i bar_color = Eigen::Vector3i(245, 245, 245);  ///< encoded RGB

  // cube
  double cube_size = 0.75;     ///< edge over the object's diameter, both as seen in the image
  double cube_distance = 0.6;  ///< share of the object's distance
  int cover_frame = -1;        ///< frame at which it covers most; negative: counted from the end, -1: the default (75)
  int leave_frame = -1;        ///< frame at which it has left the view; -1: 40 before the end

  // mesh
  Mesh mesh;
  std::vector<Pose> T_camera_mesh;  ///< one a frame; it stays at the last
};

struct Occluder {
  DrawnMesh mesh;
  std::array<Eigen::Vector3d, 8> corners;
  PoseAt T_camera_occluder;
  Finish finish;
};

/// `object_motion` and `object`: what it is to pass in front of. Throws Error(invalid_argument).
Occluder make_occluder(const OccluderOptions& options, const Mesh& object, const PoseAt& object_motion,
                       const Camera& camera, int frames, std::uint64_t seed);

}  // namespace holdfast::simulation
