#include "baking/outline_guard.hpp"

namespace holdfast::baking {
namespace {

/// Poses are elsewhere from so many object radii and radians on: a few times what an outline is off by.
constexpr double kApartPlace = 0.05, kApartTurn = 0.05;
/// Share of the contour's lines whose edge is next to it, from which on the outline is clear.
constexpr double kClear = 0.85;

bool is_clear(const FrameResult& shape) {
  return shape.status == Status::held && shape.contour.near_lines >= kClear * shape.contour.lines;
}

Mesh shape_of(Mesh mesh) {
  for (Material& material : mesh.materials) material.texture = {};
  mesh.colors.clear();
  return mesh;
}

}  // namespace

OutlineGuard::OutlineGuard(const Mesh& mesh, const Camera& camera, const TrackerOptions& options, const Device& device)
    : shape_(shape_of(mesh), camera, options, device), p_object_center_(mesh.center()), radius_(mesh.radius()) {}

std::optional<Pose> OutlineGuard::first_pose(const ImageView& frame, const Pose& T_camera_object) {
  shape_.reset(T_camera_object);
  const FrameResult result = shape_.track(frame);
  const bool clear = is_clear(result);
  shape_.reset(clear ? result.T_camera_object : T_camera_object);
  return clear ? std::optional(result.T_camera_object) : std::nullopt;
}

FrameResult OutlineGuard::check(Tracker& tracker, const ImageView& frame, std::optional<double> time_s,
                                const FrameResult& result) {
  const FrameResult shape = shape_.track(frame, time_s);
  const bool held = result.status == Status::held;
  if (is_clear(shape) && (!held || apart(shape.T_camera_object, result.T_camera_object))) {
    tracker.reset(shape.T_camera_object, frame, time_s);
    return shape;
  }
  if (held && shape.status == Status::lost) shape_.reset(result.T_camera_object, frame, time_s);
  return result;
}

bool OutlineGuard::apart(const Pose& T_a, const Pose& T_b) const {
  return (T_a * p_object_center_ - T_b * p_object_center_).norm() > kApartPlace * radius_ ||
         rotation_angle(T_a.linear() * T_b.linear().transpose()) > kApartTurn;
}

}  // namespace holdfast::baking
