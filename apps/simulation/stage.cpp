#include "simulation/stage.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "holdfast/error.hpp"

namespace holdfast::simulation {

Pose between(const Pose& from, const Pose& to, double share) {
  Pose pose = Pose::Identity();
  const Eigen::Quaterniond turn(from.linear()), end(to.linear());
  pose.linear() = turn.slerp(share, end).normalized().toRotationMatrix();
  pose.translation() = from.translation() + share * (to.translation() - from.translation());
  return pose;
}

Stage::Stage(const MotionOptions& options, const Mesh& mesh, const Camera& camera)
    : camera_(camera), corners_(bounding_corners(mesh)), options_(options) {
  center_ = 0.5 * (corners_.front() + corners_.back());
  half_size_ = corners_.back() - center_;
  const double radius = half_size_.norm();
  if (options_.nearest <= 0) {
    options_.nearest =
        std::max(2.0 * radius, 2.4 * radius * std::max(camera.fx / camera.width, camera.fy / camera.height));
  }
  if (options_.farthest <= 0) options_.farthest = 2.0 * options_.nearest;
  if (options_.nearest <= radius) {
    throw Error(ErrorCode::invalid_argument,
                "motion: the nearest distance is within the object's radius; move it farther away");
  }
  if (options_.farthest < options_.nearest) {
    throw Error(ErrorCode::invalid_argument, "motion: the farthest distance is below the nearest; swap them");
  }
}

Pose Stage::pose(const Placement& p) const {
  const double angle = p.turn.norm();
  Pose pose = Pose::Identity();
  pose.linear() = options_.orientation;
  if (angle > 0) pose.linear() = Eigen::AngleAxisd(angle, p.turn / angle) * options_.orientation;
  const double z = options_.nearest * std::pow(options_.farthest / options_.nearest, 0.5 * (1.0 + p.distance));
  // Half the extent of the turned bounding box along the camera's axes; rounded at zero so that motion stays smooth.
  Eigen::Vector3d half;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d reach = pose.linear().row(axis).transpose().cwiseProduct(half_size_);
    half[axis] = (reach.array().square() + std::pow(0.02 * half_size_.norm(), 2)).sqrt().sum();
  }
  const double front = std::max(z - half.z(), 0.1 * z);
  const auto place = [&](double share, double size, double focal, double center, double extent) {
    // Image positions of the centre at which the box's front still ends within the margin.
    const double low = ((options_.margin - center) * front + focal * extent) / z;
    const double high = ((size - 1 - options_.margin - center) * front - focal * extent) / z;
    const double room = 0.5 * (high - low);
    const double soft = 0.02 * size;  // where the object does not fit it stays near the middle
    return (0.5 * (high + low) + share * 0.5 * (room + std::hypot(room, soft))) / focal * z;
  };
  const Eigen::Vector3d center_camera(place(p.across, camera_.width, camera_.fx, camera_.cx, half.x()),
                                      place(p.down, camera_.height, camera_.fy, camera_.cy, half.y()), z);
  pose.translation() = center_camera - pose.linear() * center_;
  return pose;
}

Eigen::Matrix<double, 16, 1> Stage::flow(const Pose& a, const Pose& b) const {
  Eigen::Matrix<double, 16, 1> result;
  for (int i = 0; i < 8; ++i) {
    result.segment<2>(2 * i) =
        pixel(b * corners_[static_cast<std::size_t>(i)]) - pixel(a * corners_[static_cast<std::size_t>(i)]);
  }
  return result;
}

bool Stage::in_view(const Pose& pose) const {
  const Eigen::Vector2d center = pixel(pose * center_);
  int outside = 0;
  for (const Eigen::Vector3d& corner : corners_) {
    const Eigen::Vector2d p = pixel(pose * corner);
    if (p.x() < 0 || p.y() < 0 || p.x() > camera_.width - 1 || p.y() > camera_.height - 1) ++outside;
  }
  const double slack_x = 0.25 * camera_.width, slack_y = 0.25 * camera_.height;
  return outside <= 2 && center.x() > slack_x && center.x() < camera_.width - slack_x && center.y() > slack_y &&
         center.y() < camera_.height - slack_y;
}

Eigen::Vector2d Stage::pixel(const Eigen::Vector3d& p) const {
  return {camera_.fx * p.x() / p.z() + camera_.cx, camera_.fy * p.y() / p.z() + camera_.cy};
}

}  // namespace holdfast::simulation
