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
  return {{"in OpenGL's axes, y up and z backwards (negate its second and third row)", turned(T, flip, none, true)},
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

void require_in_front(const Mesh& mesh, const Pose& T_camera_object) {
  const Eigen::Vector3d center = T_camera_object * mesh.center();
  if (center.z() > 0) return;
  // The rotation's readings change no distance; of those that share a place the first one is named.
  std::string meant;
  std::vector<Eigen::Vector3d> places;
  for (const PoseReading& reading : other_readings(T_camera_object)) {
    const Eigen::Vector3d place = reading.T_camera_object * mesh.center();
    const auto same = [&](const Eigen::Vector3d& other) { return place.isApprox(other); };
    if (places.size() == 2 || place.z() <= 0 || std::any_of(places.begin(), places.end(), same)) continue;
    places.push_back(place);
    meant += (meant.empty() ? ": is it " : ", or ") + reading.name;
  }
  throw Error(ErrorCode::pose,
              fmt::format("the first pose puts the object behind the camera (z = {:.3g} m; x is right, y down, z "
                          "forward){}",
                          center.z(), meant.empty() ? "" : meant + "?"));
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

}  // namespace holdfast::app
