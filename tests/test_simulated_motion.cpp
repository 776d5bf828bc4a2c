// How simulated objects move: as fast as asked for, smoothly or in straight lines, in view.
#include <doctest/doctest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "holdfast/error.hpp"
#include "simulation/sequence.hpp"
#include "simulation/textured_box.hpp"
#include "support/simulated_scene.hpp"

namespace holdfast::simulation {
namespace {

using namespace test;

// The fastest corner's motion from each frame to the next, by OpenCV's camera model.
std::vector<double> corner_speeds(const Sequence& sequence, const Mesh& mesh) {
  std::vector<double> speeds;
  std::vector<cv::Point2d> last;
  for (const Pose& pose : sequence.poses()) {
    const std::vector<cv::Point2d> pixels = project(corners_of(mesh), pose, sequence.camera());
    double fastest = 0;
    for (std::size_t i = 0; i < last.size(); ++i) fastest = std::max(fastest, cv::norm(pixels[i] - last[i]));
    if (!last.empty()) speeds.push_back(fastest);
    last = pixels;
  }
  return speeds;
}

// The camera, length and distances of the paper's experiments.
SequenceOptions at_paper_distances() {
  SequenceOptions options;
  options.camera = {512, 256, 685, 685, 255.5, 127.5, {}};
  options.frames = 300;
  options.motion.nearest = 0.6;
  options.motion.farthest = 1.2;
  return options;
}

TEST_CASE("Corners move as fast as asked for, and the object stays in view between the distances") {
  const Mesh box = textured_box();
  SequenceOptions options = at_paper_distances();
  for (const MotionStyle style : {MotionStyle::smooth, MotionStyle::sharp}) {
    for (const double speed : {1.5, 6.0, 12.0}) {
      for (const std::uint64_t seed : {1, 2, 3}) {
        CAPTURE(static_cast<int>(style));
        CAPTURE(speed);
        CAPTURE(seed);
        options.motion.style = style;
        options.motion.speed = speed;
        options.seed = seed;
        const Sequence sequence(box, options);
        const std::vector<double> speeds = corner_speeds(sequence, box);
        const auto share = [&](double low, double high) {
          return static_cast<double>(std::count_if(speeds.begin(), speeds.end(),
                                                   [&](double s) { return s > low * speed && s <= high * speed; })) /
                 static_cast<double>(speeds.size());
        };
        const MotionSummary summary = summarize_motion(sequence.poses(), box, options.camera);
        CHECK(summary.corner_speed.size() == speeds.size());
        CHECK(summary.max_speed == doctest::Approx(*std::max_element(speeds.begin(), speeds.end())));
        if (style == MotionStyle::smooth) {
          CHECK(share(0, 1.0001) == doctest::Approx(0.95).epsilon(0.01));
        } else {
          CHECK(share(0.97, 1.01) >= 0.93);
          CHECK(share(1.01, 100) == 0);
          CHECK(summary.turns >= options.motion.turns);
        }
        CHECK(summary.nearest > 0.6 * 0.999);
        CHECK(summary.farthest < 1.2 * 1.001);
        for (const Pose& pose : sequence.poses()) {
          int outside = 0;
          for (const cv::Point2d& p : project(corners_of(box), pose, options.camera)) {
            if (p.x < 0 || p.y < 0 || p.x > 511 || p.y > 255) ++outside;
          }
          CHECK(outside <= 4);
          CHECK(std::abs(pose.linear().determinant() - 1) < 1e-9);
        }
      }
    }
  }
}

TEST_CASE("Eased motion starts at rest, turns at rest, and gains speed evenly in between") {
  const Mesh box = textured_box();
  SequenceOptions options = at_paper_distances();
  options.motion.style = MotionStyle::sharp;
  options.motion.speed = 6;
  options.motion.ease = 10;
  for (const std::uint64_t seed : {1, 2, 3}) {
    CAPTURE(seed);
    options.seed = seed;
    const Sequence sequence(box, options);
    const std::vector<double> speeds = corner_speeds(sequence, box);
    // Half an acceleration in the first frame; at most one more in each further one (a little more where the path's
    // pixels are counted along a curve).
    CHECK(speeds.front() == doctest::Approx(0.3).epsilon(0.05));
    for (std::size_t i = 1; i < speeds.size(); ++i) CHECK(std::abs(speeds[i] - speeds[i - 1]) < 0.65);
    CHECK(*std::max_element(speeds.begin(), speeds.end()) < 6.1);
    CHECK(std::count_if(speeds.begin(), speeds.end(), [](double s) { return s > 5.8; }) > 120);
    CHECK(summarize_motion(sequence.poses(), box, options.camera).turns >= options.motion.turns);
  }
  options.motion.ease = 60;
  CHECK_THROWS_AS(Sequence(box, options), Error);
}

TEST_CASE("Smooth motion has no corners: its acceleration is small beside its speed") {
  const Mesh box = textured_box();
  SequenceOptions options;
  options.motion.speed = 6;
  const Sequence sequence(box, options);
  const auto corners = corners_of(box);
  double largest = 0;
  for (int i = 1; i + 1 < sequence.size(); ++i) {
    const auto a = project(corners, sequence.pose(i - 1), sequence.camera());
    const auto b = project(corners, sequence.pose(i), sequence.camera());
    const auto c = project(corners, sequence.pose(i + 1), sequence.camera());
    for (std::size_t k = 0; k < 8; ++k) largest = std::max(largest, cv::norm(c[k] - 2 * b[k] + a[k]));
  }
  CHECK(largest < 1.5);  // pixels a frame squared; a sharp turn back at this speed has 12
}

TEST_CASE("The cube covers most of the object near the end, then leaves") {
  const Mesh box = textured_box();
  SequenceOptions options = at_paper_distances();
  options.motion.style = MotionStyle::sharp;
  options.motion.speed = 6;
  OccluderOptions cube;
  cube.kind = OccluderKind::cube;
  options.occluders = {cube};
  for (const std::uint64_t seed : {1, 2, 3}) {
    CAPTURE(seed);
    options.seed = seed;
    const Sequence sequence(box, options);
    double least = 1;
    for (int i = 200; i < 260; i += 2) least = std::min(least, sequence.visible_share(i));
    CHECK(least < 0.15);
    for (int i = 260; i < 300; i += 3) CHECK(sequence.visible_share(i) == 1);
  }
}

}  // namespace
}  // namespace holdfast::simulation
