// Objects without texture, followed by their contour: how well, what is said of them, and when it is used.
#include <doctest/doctest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "holdfast/tracker.hpp"
#include "simulation/sequence.hpp"
#include "support/check_error.hpp"
#include "support/paper_box.hpp"
#include "support/render_comparison.hpp"
#include "support/simulated.hpp"

namespace {

using namespace holdfast;
using simulation::Sequence;
using simulation::SequenceOptions;
using test::clutter;
using test::kDegrees;
using test::pose_error;
using test::PoseError;
using test::view_of;

/// A wedge with a step: no two of its silhouettes are alike. Painted in one colour.
Mesh painted_wedge() {
  // Corners of the front in x and y (metres), seen from +z, extruded.
  const std::vector<Eigen::Vector2f> front{{-0.08F, -0.05F}, {0.08F, -0.05F}, {0.08F, 0.0F},
                                           {0.02F, 0.0F},    {0.02F, 0.05F},  {-0.05F, 0.05F}};
  Mesh mesh;
  const auto count = static_cast<std::uint32_t>(front.size());
  for (const float z : {-0.03F, 0.03F}) {
    for (const Eigen::Vector2f& point : front) mesh.positions.emplace_back(point.x(), point.y(), z);
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t next = (i + 1) % count;
    mesh.triangles.push_back({i, next, next + count});
    mesh.triangles.push_back({i, next + count, i + count});
  }
  // It is star-shaped as seen from its fourth corner.
  for (std::uint32_t i = 1; i + 1 < count; ++i) {
    const std::uint32_t a = 3, b = (3 + i) % count, c = (4 + i) % count;
    mesh.triangles.push_back({a, c, b});
    mesh.triangles.push_back({a + count, b + count, c + count});
  }
  mesh.colors.assign(mesh.positions.size(), {190, 120, 50, 255});
  return mesh;
}

Mesh shape_of(Mesh mesh) {
  mesh.colors.clear();
  return mesh;
}

SequenceOptions moderate_motion(int frames, std::uint64_t seed) {
  SequenceOptions options;
  options.camera = {512, 384, 600, 600, 255.5, 191.5, {}};
  options.frames = frames;
  options.seed = seed;
  options.motion.nearest = 0.5;
  options.motion.farthest = 0.65;
  options.motion.speed = 5;
  options.sensor.noise = 2;
  options.sensor.blur_sigma = 0.5;
  return options;
}

struct Followed {
  std::vector<FrameResult> results;
  std::vector<PoseError> errors;

  double median(double PoseError::*of) const {
    std::vector<double> values;
    for (const PoseError& error : errors) values.push_back(error.*of);
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  }
  long held() const {
    return std::count_if(results.begin(), results.end(),
                         [](const FrameResult& result) { return result.status == Status::held; });
  }
};

Followed follow(Tracker& tracker, const Sequence& sequence) {
  Followed followed;
  tracker.reset(sequence.pose(0));
  for (int i = 0; i < sequence.size(); ++i) {
    const cv::Mat frame = sequence.frame(i);
    followed.results.push_back(tracker.track(view_of(frame)));
    followed.errors.push_back(pose_error(sequence.pose(i), followed.results.back().T_camera_object));
  }
  return followed;
}

}  // namespace

TEST_CASE("a shape without texture is held by its contour, and the same frames give the same poses") {
  const Sequence sequence(painted_wedge(), moderate_motion(40, 41));
  Tracker tracker(shape_of(painted_wedge()), sequence.camera());
  const Followed first = follow(tracker, sequence), second = follow(tracker, sequence);
  CHECK(first.held() == 40);
  CHECK(first.median(&PoseError::millimetres) < 0.6);
  CHECK(first.median(&PoseError::degrees) < 0.4);
  for (std::size_t i = 0; i < first.results.size(); ++i) {
    CAPTURE(i);
    CHECK(first.errors[i].millimetres < 5);
    CHECK(first.errors[i].degrees < 3);
    CHECK(first.results[i].contour.holds);
    CHECK_FALSE(first.results[i].texture.holds);
    CHECK(first.results[i].contour.telling_lines > 50);
    CHECK(first.results[i].T_camera_object.matrix() == second.results[i].T_camera_object.matrix());
    const Matrix6& covariance = first.results[i].covariance;
    CHECK(covariance.diagonal().minCoeff() > 0);
    CHECK((covariance * first.results[i].information - Matrix6::Identity()).norm() < 1e-6);
  }
}

TEST_CASE("a shape in one colour is followed with its paint as without, and print holds what is printed") {
  const Sequence sequence(painted_wedge(), moderate_motion(12, 43));
  Tracker shape(shape_of(painted_wedge()), sequence.camera()), painted(painted_wedge(), sequence.camera());
  const Followed by_shape = follow(shape, sequence), by_paint = follow(painted, sequence);
  CHECK(by_shape.held() == sequence.size());
  for (std::size_t i = 0; i < by_paint.results.size(); ++i) {
    CHECK(by_paint.results[i].T_camera_object.isApprox(by_shape.results[i].T_camera_object, 0));
  }
  const Sequence printed(test::box(), test::paper_camera(3, 2, 17));
  Tracker box(test::box(), printed.camera());
  for (const FrameResult& result : follow(box, printed).results) CHECK(result.texture.holds);
}

TEST_CASE("a first pose that is off is mended, in refine() too, which changes nothing else") {
  const Sequence sequence(painted_wedge(), moderate_motion(6, 47));
  Tracker tracker(shape_of(painted_wedge()), sequence.camera());
  Pose T_off = sequence.pose(0);
  T_off.linear() = Eigen::AngleAxisd(3 / kDegrees, Eigen::Vector3d(1, 2, 2).normalized()) * T_off.linear();
  T_off.translation() += Eigen::Vector3d(0.004, -0.003, 0.008);
  tracker.reset(T_off);
  const cv::Mat first = sequence.frame(0), second = sequence.frame(1);
  const FrameResult start = tracker.track(view_of(first));
  CHECK(start.status == Status::held);
  CHECK(pose_error(sequence.pose(0), start.T_camera_object).millimetres < 2);
  CHECK(pose_error(sequence.pose(0), start.T_camera_object).degrees < 1.5);

  const FrameResult refined = tracker.refine(view_of(second), sequence.pose(0));
  CHECK(pose_error(sequence.pose(1), refined.T_camera_object).millimetres < 2);
  const FrameResult next = tracker.track(view_of(second));
  Tracker other(shape_of(painted_wedge()), sequence.camera());
  other.reset(T_off);
  other.track(view_of(first));
  CHECK(next.T_camera_object.matrix() == other.track(view_of(second)).T_camera_object.matrix());
}

// The print's colours and those of the surroundings are mixed up where a first pose is off.
TEST_CASE("whichever way a first pose is off by 5 mm and 3 degrees, a printed box is found by its outline") {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto direction = [&] { return Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized(); };
  int found = 0, near = 0;
  for (std::uint64_t seed = 81; seed < 91; ++seed) {
    const Sequence sequence(test::box(), test::noisy_box(1, seed, 0.5, 0.7));
    const cv::Mat frame = sequence.frame(0);
    Mesh shape = test::box();
    shape.materials.clear();
    Tracker tracker(shape, sequence.camera());
    for (int i = 0; i < 10; ++i) {
      Pose T_off = sequence.pose(0);
      T_off.linear() = Eigen::AngleAxisd(3 / kDegrees, direction()) * T_off.linear();
      T_off.translation() += 0.005 * direction();
      tracker.reset(T_off);
      const FrameResult result = tracker.track(view_of(frame));
      found += result.status == Status::held;
      const PoseError error = pose_error(sequence.pose(0), result.T_camera_object);
      near += error.degrees < 2;
    }
  }
  CHECK(found == 100);
  CHECK(near >= 98);
}

TEST_CASE("the object gone: lost, with a reason; back at the same place: held") {
  const Sequence sequence(painted_wedge(), moderate_motion(4, 53));
  Tracker tracker(shape_of(painted_wedge()), sequence.camera());
  tracker.reset(sequence.pose(0));
  for (int i = 0; i < 3; ++i) {
    const cv::Mat frame = sequence.frame(i);
    CHECK(tracker.track(view_of(frame)).status == Status::held);
  }
  const cv::Mat empty = clutter(sequence.camera());
  for (int i = 0; i < 3; ++i) {
    const FrameResult lost = tracker.track(view_of(empty));
    CHECK(lost.status == Status::lost);
    CHECK(lost.reason != Reason::none);
    CHECK_FALSE(lost.message.empty());
  }
  const cv::Mat frame = sequence.frame(2);
  const FrameResult back = tracker.track(view_of(frame));
  CHECK(back.status == Status::held);
  CHECK(pose_error(sequence.pose(2), back.T_camera_object).millimetres < 3);
}

// A bar's edge beside the contour is sometimes taken for it; in which frames hangs on last digits.
TEST_CASE("bars that sweep across: held or lost, hardly ever held elsewhere") {
  long held = 0;
  int wrong = 0, explained = 0;
  for (std::uint64_t seed = 61; seed < 73; ++seed) {
    CAPTURE(seed);
    SequenceOptions options = moderate_motion(60, seed);
    options.occluders = {simulation::OccluderOptions{}};
    const Sequence sequence(painted_wedge(), options);
    Tracker tracker(shape_of(painted_wedge()), sequence.camera());
    const Followed followed = follow(tracker, sequence);
    held += followed.held();
    for (std::size_t i = 0; i < followed.results.size(); ++i) {
      CAPTURE(i);
      if (followed.results[i].status != Status::held) continue;
      wrong += followed.errors[i].degrees > 5 || followed.errors[i].millimetres > 20;
      if (followed.results[i].message.starts_with("contour hidden")) {
        ++explained;
        CHECK(sequence.visible_share(static_cast<int>(i)) < 0.95);
      }
    }
  }
  CHECK(held > 580);  // of 720
  CHECK(wrong < 36);
  CHECK(explained > 3);
}

TEST_CASE("grey frames") {
  SequenceOptions options = moderate_motion(20, 61);
  Mesh mesh = painted_wedge();
  mesh.colors.assign(mesh.positions.size(), {250, 250, 250, 255});
  const Sequence sequence(mesh, options);
  Tracker tracker(shape_of(mesh), sequence.camera());
  tracker.reset(sequence.pose(0));
  for (int i = 0; i < sequence.size(); ++i) {
    cv::Mat grey;
    cv::cvtColor(sequence.frame(i), grey, cv::COLOR_BGR2GRAY);
    const FrameResult result = tracker.track(view_of(grey, PixelFormat::grey8));
    CAPTURE(i);
    CHECK(result.status == Status::held);
    CHECK(pose_error(sequence.pose(i), result.T_camera_object).millimetres < 8);
  }
}

TEST_CASE("the pixel mask shows the contour: used where it was found") {
  const Sequence sequence(painted_wedge(), moderate_motion(4, 67));
  Tracker tracker(shape_of(painted_wedge()), sequence.camera());
  follow(tracker, sequence);
  const PixelMask mask = tracker.pixel_mask();
  const cv::Mat object = sequence.make(3).object_mask > 127;
  cv::Mat outside, inside;
  cv::distanceTransform(~object, outside, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  cv::distanceTransform(object, inside, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  int used = 0, surface = 0;
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      const auto value = static_cast<PixelClass>(mask.classes[static_cast<std::size_t>(y * mask.width + x)]);
      if (value == PixelClass::not_visible) continue;
      ++surface;
      if (value != PixelClass::used) continue;
      ++used;
      CHECK(std::max(outside.at<float>(y, x), inside.at<float>(y, x)) < 2.5);
    }
  }
  CHECK(used > 100);
  CHECK(surface > 0.9 * cv::countNonZero(object));
  CHECK(tracker.rendered_view().depth.size() == mask.classes.size());
}

TEST_CASE("not in paper mode, nor when it is not wanted") {
  const Mesh mesh = shape_of(painted_wedge());
  const Camera camera = moderate_motion(1, 1).camera;
  CHECK_ERROR(Tracker(mesh, camera, TrackerOptions::paper()), ErrorCode::model, "neither texture nor vertex colours");
  TrackerOptions options;
  options.contour = false;
  CHECK_ERROR(Tracker(mesh, camera, options), ErrorCode::model, "neither texture nor vertex colours", "contour");
}
