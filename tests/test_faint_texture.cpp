// Objects printed in places only: texture and contour together, and either alone where the other says nothing.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "holdfast/tracker.hpp"
#include "simulation/sequence.hpp"
#include "support/paper_box.hpp"
#include "support/simulated.hpp"

namespace {

using namespace holdfast;
using simulation::Sequence;
using simulation::SequenceOptions;
using test::kDegrees;
using test::pose_error;
using test::PoseError;
using test::view_of;

using Vector2 = Eigen::Vector2f;
using Vector3 = Eigen::Vector3f;

/// 64 x 64 texels: squares of chance colours on plain material, or the material alone.
Texture print(bool printed) {
  Texture texture;
  texture.width = texture.height = 64;
  std::uint32_t state = 12345;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      if (x % 8 == 0) state = static_cast<std::uint32_t>(x / 8 + 8 * (y / 8) + 1) * 2654435761U;
      for (int c = 0; c < 3; ++c) {
        texture.rgba.push_back(printed ? static_cast<std::uint8_t>(40 + ((state >> (8 * c)) & 127U))
                                       : static_cast<std::uint8_t>(190 - 60 * c));
      }
      texture.rgba.push_back(255);
    }
  }
  return texture;
}

/// A solid with two materials: the first is printed, the second plain.
struct Solid {
  Mesh mesh;

  Solid() {
    for (const bool printed : {true, false}) {
      Material material;
      material.name = printed ? "print" : "plain";
      material.texture = print(printed);
      mesh.materials.push_back(material);
    }
  }

  /// Corners anticlockwise as seen from outside; this part of the texture's width.
  void face(const std::array<Vector3, 4>& corners, bool printed, float u0 = 0, float u1 = 1) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    const std::array<Vector2, 4> places{Vector2(u0, 0), Vector2(u1, 0), Vector2(u1, 1), Vector2(u0, 1)};
    for (std::size_t i = 0; i < 4; ++i) {
      mesh.positions.push_back(corners[i]);
      mesh.texture_coordinates.push_back(places[i]);
    }
    for (const std::uint32_t last : {2U, 3U}) {
      mesh.triangles.push_back({first, first + last - 1, first + last});
      mesh.triangle_materials.push_back(printed ? 0 : 1);
    }
  }
};

/// 140 x 100 x 80 mm, y up; a label of 50 x 40 mm on its front.
Mesh labelled_box() {
  Solid solid;
  const float x = 0.07F, y = 0.05F, z = 0.04F, u = 0.025F, v = 0.02F;
  const auto quad = [](float x0, float y0, float x1, float y1, float at_z) {
    return std::array<Vector3, 4>{Vector3(x0, y0, at_z), Vector3(x1, y0, at_z), Vector3(x1, y1, at_z),
                                  Vector3(x0, y1, at_z)};
  };
  solid.face(quad(-u, -v, u, v, z), true);
  solid.face(quad(-x, -y, x, -v, z), false);
  solid.face(quad(-x, v, x, y, z), false);
  solid.face(quad(-x, -v, -u, v, z), false);
  solid.face(quad(u, -v, x, v, z), false);
  solid.face({Vector3(x, -y, -z), Vector3(-x, -y, -z), Vector3(-x, y, -z), Vector3(x, y, -z)}, false);
  solid.face({Vector3(x, -y, z), Vector3(x, -y, -z), Vector3(x, y, -z), Vector3(x, y, z)}, false);
  solid.face({Vector3(-x, -y, -z), Vector3(-x, -y, z), Vector3(-x, y, z), Vector3(-x, y, -z)}, false);
  solid.face({Vector3(-x, y, z), Vector3(x, y, z), Vector3(x, y, -z), Vector3(-x, y, -z)}, false);
  solid.face({Vector3(-x, -y, -z), Vector3(x, -y, -z), Vector3(x, -y, z), Vector3(-x, -y, z)}, false);
  return solid.mesh;
}

/// A cylinder, 70 mm wide and 120 high, printed on a third of its side: its contour never shows how it is turned.
Mesh labelled_can() {
  Solid solid;
  constexpr int kSides = 36;
  const float radius = 0.035F, high = 0.06F;
  const auto rim = [&](int side, float y) {
    const double angle = 2 * M_PI * side / kSides;
    return Vector3(radius * static_cast<float>(std::sin(angle)), y, radius * static_cast<float>(std::cos(angle)));
  };
  for (int side = 0; side < kSides; ++side) {
    const Vector3 a = rim(side, -high), b = rim(side + 1, -high), c = rim(side + 1, high), d = rim(side, high);
    const float left = static_cast<float>(side < kSides / 2 ? side : side - kSides) / (kSides / 3) + 0.5F;
    const float right = left + 3.0F / kSides;
    solid.face({a, b, c, d}, left >= 0 && right <= 1.001F, left, right);
    const Vector3 top(0, high, 0), bottom(0, -high, 0);
    solid.face({d, c, top, 0.5F * (d + top)}, false);
    solid.face({b, a, bottom, 0.5F * (b + bottom)}, false);
  }
  return solid.mesh;
}

/// Turns about its upright axis by so many radians and back again, tilted a little and swaying.
std::vector<Pose> turning(int frames, double farthest) {
  std::vector<Pose> poses;
  for (int i = 0; i < frames; ++i) {
    const double phase = 2 * M_PI * i / frames;
    Pose pose = Pose::Identity();
    pose.linear() = (Eigen::AngleAxisd(M_PI + 0.35, Eigen::Vector3d::UnitX()) *
                     Eigen::AngleAxisd(0.5 * farthest * (1 - std::cos(phase)), Eigen::Vector3d::UnitY()))
                        .toRotationMatrix();
    pose.translation() = Eigen::Vector3d(0.02 * std::sin(2 * phase), 0.01 * std::sin(3 * phase), 0.5);
    poses.push_back(pose);
  }
  return poses;
}

SequenceOptions seen_turning(int frames, double farthest) {
  SequenceOptions options;
  options.camera = {512, 384, 600, 600, 255.5, 191.5, {}};
  options.frames = frames;
  options.seed = 71;
  options.motion.T_camera_object = turning(frames, farthest);
  options.sensor.noise = 2;
  options.sensor.blur_sigma = 0.5;
  return options;
}

struct Frame {
  FrameResult result;
  PoseError error;
  bool held() const { return result.status == Status::held; }
};

std::vector<Frame> follow(const Mesh& mesh, const Sequence& sequence, const TrackerOptions& options = {}) {
  Tracker tracker(mesh, sequence.camera(), options);
  tracker.reset(sequence.pose(0));
  std::vector<Frame> frames;
  for (int i = 0; i < sequence.size(); ++i) {
    const cv::Mat frame = sequence.frame(i);
    const FrameResult result = tracker.track(view_of(frame));
    frames.push_back({result, pose_error(sequence.pose(i), result.T_camera_object)});
    CHECK(tracker.pixel_mask().classes.size() == static_cast<std::size_t>(512 * 384));
  }
  return frames;
}

double median_mm(const std::vector<Frame>& frames) {
  std::vector<double> values;
  for (const Frame& frame : frames) values.push_back(frame.error.millimetres);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

TrackerOptions texture_alone() {
  TrackerOptions options;
  options.contour = false;
  return options;
}

}  // namespace

TEST_CASE("a label that turns away and comes back: followed all along, by the contour alone meanwhile") {
  const Sequence sequence(labelled_box(), seen_turning(110, 2.6));
  const std::vector<Frame> frames = follow(labelled_box(), sequence), again = follow(labelled_box(), sequence);
  int by_contour = 0, lost = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    CAPTURE(i);
    lost += !frames[i].held();
    CHECK(frames[i].error.millimetres < 8);
    CHECK(frames[i].error.degrees < 5);
    by_contour += !frames[i].result.texture.holds;
    CHECK(frames[i].result.T_camera_object.matrix() == again[i].result.T_camera_object.matrix());
    CHECK(frames[i].result.covariance.diagonal().minCoeff() > 0);
  }
  CHECK(by_contour > 20);
  CHECK(lost <= 8);  // of 110
  CHECK(by_contour < 70);
  CHECK(frames.front().result.texture.holds);
  CHECK(frames.back().result.texture.holds);
  // Texture alone cannot do it.
  const std::vector<Frame> alone = follow(labelled_box(), sequence, texture_alone());
  CHECK(std::count_if(alone.begin(), alone.end(), [](const Frame& frame) { return frame.held(); }) < 80);
}

TEST_CASE("started from a side without print: by the contour until the label comes, then by both") {
  SequenceOptions options = seen_turning(60, 2.6);
  std::vector<Pose>& poses = options.motion.T_camera_object;
  poses = turning(110, 2.6);
  poses.erase(poses.begin(), poses.begin() + 50);
  const Sequence sequence(labelled_box(), options);
  const std::vector<Frame> frames = follow(labelled_box(), sequence);
  CHECK(frames.front().result.contour.holds);
  CHECK_FALSE(frames.front().result.texture.holds);
  CHECK(frames.back().result.texture.holds);
  CHECK(frames.back().error.millimetres < 1);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    CAPTURE(i);
    CHECK(frames[i].held());
    CHECK(frames[i].error.degrees < 3);
  }
}

TEST_CASE("a small label tells less than it and the contour together") {
  SequenceOptions options = seen_turning(40, 0.8);
  options.sensor.noise = 6;
  options.sensor.blur_sigma = 1;
  const Sequence sequence(labelled_box(), options);
  TrackerOptions contour_alone;
  contour_alone.ablate = {"texture"};
  const double both = median_mm(follow(labelled_box(), sequence)),
               label = median_mm(follow(labelled_box(), sequence, texture_alone())),
               contour = median_mm(follow(labelled_box(), sequence, contour_alone));
  MESSAGE("median errors, mm: label ", label, ", contour ", contour, ", both ", both);
  CHECK(both < 0.8 * label);
  CHECK(both < contour);
}

TEST_CASE(
    "a can whose print is out of view: its turn is known to be unknown, or it is lost; the print tells it again") {
  const Sequence sequence(labelled_can(), seen_turning(120, 3.1));
  const std::vector<Frame> frames = follow(labelled_can(), sequence);
  int held = 0, believed = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!frames[i].held()) continue;
    ++held;
    const Matrix6& covariance = frames[i].result.covariance;
    const double deviation = kDegrees * std::sqrt(covariance(4, 4));  // about its own axis
    believed += frames[i].error.degrees < 3 * deviation + 2;
  }
  MESSAGE("held in ", held, " frames of 120, the turn within what is said in ", believed);
  CHECK(held > 50);
  // Once the print has been away for some frames the contour is believed, and does not tell the turn: a weakness.
  CHECK(believed > 0.6 * held);
  CHECK(frames.back().held());
  CHECK(frames.back().error.millimetres < 2);
  CHECK(frames.back().error.degrees < 3);
}

TEST_CASE("a can that turns all the way round: found again by the print it started with") {
  constexpr int kFrames = 120;
  SequenceOptions options = seen_turning(kFrames, 0);
  for (int i = 0; i < kFrames; ++i) {
    Pose& pose = options.motion.T_camera_object[static_cast<std::size_t>(i)];
    pose.linear() = pose.linear() * Eigen::AngleAxisd(2 * M_PI * i / (kFrames - 10), Eigen::Vector3d::UnitY());
  }
  const Sequence sequence(labelled_can(), options);
  const std::vector<Frame> frames = follow(labelled_can(), sequence);
  CHECK(frames.back().held());
  CHECK(frames.back().result.texture.holds);
  CHECK(frames.back().error.millimetres < 2);
  CHECK(frames.back().error.degrees < 2);
}

TEST_CASE("where texture tells much more, the contour hardly changes what it says") {
  const Sequence sequence(test::box(), test::paper_camera(12, 3, 17));
  Tracker with(test::box(), sequence.camera()), without(test::box(), sequence.camera(), texture_alone());
  with.reset(sequence.pose(0));
  without.reset(sequence.pose(0));
  for (int i = 0; i < sequence.size(); ++i) {
    CAPTURE(i);
    const cv::Mat frame = sequence.frame(i);
    const PoseError apart =
        pose_error(with.track(view_of(frame)).T_camera_object, without.track(view_of(frame)).T_camera_object);
    CHECK(apart.millimetres < 0.3);
    CHECK(apart.degrees < 0.1);
  }
}
