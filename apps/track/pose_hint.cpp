#include "track/pose_hint.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>

#include "holdfast/error.hpp"

namespace holdfast::app {
namespace {

Pose turned(const Pose& pose, const Eigen::Matrix3d& before, const Eigen::Matrix3d& after, bool translation) {
  Pose result = Pose::Identity();
  result.linear() = before * pose.linear() * after;
  result.translation() = translation ? (before * pose.translation()).eval() : pose.translation().eval();
  return result;
}

/// The ball around the model meets the picture.
bool is_seen(const Mesh& mesh, const Camera& camera, const Pose& T_camera_object) {
  const Eigen::Vector3d center = T_camera_object * mesh.center();
  if (center.z() <= 0) return false;
  const double reach = camera.fx * mesh.radius() / center.z();
  const double x = camera.cx + camera.fx * center.x() / center.z();
  const double y = camera.cy + camera.fy * center.y() / center.z();
  return x > -reach && y > -reach && x < camera.width + reach && y < camera.height + reach;
}

}  // namespace

std::vector<PoseReading> other_readings(const Pose& T) {
  const Eigen::Matrix3d flip = Eigen::Vector3d(1, -1, -1).asDiagonal();
  const Eigen::Matrix3d none = Eigen::Matrix3d::Identity();
  const auto quarter = [](double angle) {
    return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()).toRotationMatrix();
  };
  Pose moved = T;
  moved.translation() = flip * T.translation();
  const Pose inverse = T.inverse();
  Pose transposed = T;
  transposed.linear().transposeInPlace();
  const Eigen::AngleAxisd turn(T.linear());
  const double angle = T.translation().norm();
  Pose exchanged = Pose::Identity();
  if (angle > 0) exchanged.linear() = Eigen::AngleAxisd(angle, T.translation() / angle).toRotationMatrix();
  exchanged.translation() = turn.angle() * turn.axis();
  const Eigen::Quaterniond read(T.linear());
  Pose reordered = T;
  reordered.linear() = Eigen::Quaterniond(read.x(), read.y(), read.z(), read.w()).toRotationMatrix();
  return {{"with tvec before rvec (exchange them: rvec comes first)", exchanged},
          {"with its quaternion as w, x, y, z (put w last)", reordered},
          {"in OpenGL's axes, y up and z backwards (negate its second and third row)", turned(T, flip, none, true)},
          {"with its rotation still in OpenGL's axes (negate the rotation's second and third row)",
           turned(T, flip, none, false)},
          {"with its translation still in OpenGL's axes (negate y and z of the translation)", moved},
          {"as camera to object (invert it)", inverse},
          {"with its rotation transposed (exchange its rows and columns)", transposed},
          {"as camera to object in OpenGL's axes (invert it, then negate its second and third row)",
           turned(inverse, flip, none, true)},
          {"upside down (turn it by 180 degrees about the camera's axis)",
           turned(T, Eigen::Vector3d(-1, -1, 1).asDiagonal(), none, false)},
          {"for a model with z up where this one has y (turn it by 90 degrees about the model's x axis)",
           turned(T, none, quarter(std::numbers::pi / 2), false)},
          {"for a model with y up where this one has z (turn it by -90 degrees about the model's x axis)",
           turned(T, none, quarter(-std::numbers::pi / 2), false)}};
}

void require_in_view(const Mesh& mesh, const Camera& camera, const Pose& T_camera_object) {
  if (is_seen(mesh, camera, T_camera_object)) return;
  // Many readings of the rotation change no place; of those that share one the first is named.
  std::string meant;
  std::vector<Eigen::Vector3d> places;
  for (const PoseReading& reading : other_readings(T_camera_object)) {
    const Eigen::Vector3d place = reading.T_camera_object * mesh.center();
    const auto same = [&](const Eigen::Vector3d& other) { return place.isApprox(other); };
    const bool known = std::any_of(places.begin(), places.end(), same);
    if (places.size() == 2 || known || !is_seen(mesh, camera, reading.T_camera_object)) continue;
    places.push_back(place);
    meant += (meant.empty() ? ": is it " : ", or ") + reading.name;
  }
  const Eigen::Vector3d center = T_camera_object * mesh.center();
  const std::string where =
      center.z() <= 0 ? fmt::format("behind the camera (z = {:.3g} m; x is right, y down, z forward)", center.z())
                      : fmt::format(
                            "out of the picture of {}x{} pixels ({:.3g}, {:.3g}, {:.3g} m; x is right, y down, z "
                            "forward)",
                            camera.width, camera.height, center.x(), center.y(), center.z());
  throw Error(ErrorCode::pose,
              fmt::format("the first pose puts the object {}{}", where,
                          meant.empty() ? ": check the pose's unit and axes, and the camera's focal length and centre"
                                        : meant + "?"));
}

std::string lost_start(const FrameResult& first) {
  const ContourEvidence& contour = first.contour;
  // By chance an edge of the picture lies beside some of the lines.
  const bool nowhere = contour.lines > 0 && contour.near_lines < contour.lines / 2;
  return fmt::format(
      "the object is not found where the first pose puts it{}: check the pose, the model's unit and the "
      "camera; --contact-sheet shows where it is drawn",
      nowhere ? fmt::format(" (the picture has an edge at {} % of the model's contour)",
                            100 * contour.near_lines / contour.lines)
              : "");
}

std::optional<std::string> pose_hint(const Pose& T_camera_object, bool by_texture,
                                     const std::function<bool(const Pose&)>& is_held) {
  const std::vector<PoseReading> readings = other_readings(T_camera_object);
  const auto meant = std::find_if(readings.begin(), readings.end(),
                                  [&](const PoseReading& reading) { return is_held(reading.T_camera_object); });
  if (meant == readings.end()) return std::nullopt;
  return fmt::format("the object is not where the first pose puts it, but {} if that is read {}{}",
                     by_texture ? "it is found" : "its outline fits", meant->name,
                     by_texture ? "" : "; an outline alone may mislead");
}

std::string held_by_outline() {
  return "the first frame shows the model's outline at the first pose, but not its texture: an outline may fit upside "
         "down or from another side, too; --contact-sheet shows where it is drawn";
}

}  // namespace holdfast::app
