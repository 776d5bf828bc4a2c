// A plain box in grey before grey: neither texture nor the contour's colours tell its pose, its edges do.
#include <doctest/doctest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "base/corner_motion.hpp"
#include "device/device_impl.hpp"
#include "edges/edge_modality.hpp"
#include "holdfast/tracker.hpp"
#include "simulation/sequence.hpp"
#include "support/edge_shapes.hpp"
#include "support/files.hpp"
#include "support/paper_box.hpp"
#include "support/render_comparison.hpp"
#include "support/simulated.hpp"

namespace {

using namespace holdfast;
using simulation::Sequence;
using simulation::SequenceOptions;
using test::view_of;

const Eigen::Vector3f kSize(0.2F, 0.12F, 0.15F);

/// Soft patches as bright as the box's faces are.
cv::Mat grey_patches(cv::Size size, double softness) {
  cv::Mat noise(size, CV_32F), picture;
  cv::RNG(17).fill(noise, cv::RNG::NORMAL, 0, 1);
  cv::GaussianBlur(noise, noise, {}, softness);
  cv::Scalar mean, deviation;
  cv::meanStdDev(noise, mean, deviation);
  noise.convertTo(picture, CV_8U, 28 / deviation[0], 128 - mean[0] * 28 / deviation[0]);
  cv::cvtColor(picture, picture, cv::COLOR_GRAY2BGR);
  return picture;
}

/// Faces of one grey each: six levels about the background's mean.
Mesh shaded_box() {
  Mesh mesh = test::block(kSize);
  constexpr std::array<std::uint8_t, 6> kGreys{95, 150, 115, 165, 90, 130};
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const std::uint8_t grey = kGreys[i / 4];
    mesh.colors.push_back({grey, grey, grey, 255});
  }
  return mesh;
}

/// How the box is seen: three of its faces in full, or one of them and slivers of two, before finer patches.
enum class Sight { clear, poor };

struct GreyBox {
  explicit GreyBox(int frames, Sight sight = Sight::clear) : sequence(shaded_box(), options(frames, sight)) {
    for (int i = 0; i < frames; ++i) {
      greys.emplace_back();
      cv::cvtColor(sequence.frame(i), greys.back(), cv::COLOR_BGR2GRAY);
    }
  }

  SequenceOptions options(int frames, Sight sight) const {
    const double softness = sight == Sight::clear ? 14 : 9;
    cv::imwrite((folder.path() / "background.png").string(), grey_patches({640, 480}, softness));
    SequenceOptions options = test::noisy_box(frames, 3, 0.55, 0.7);
    options.lighting = simulation::LightingOptions::flat();
    options.background.file = folder.path() / "background.png";
    options.sensor.blur_sigma = 0.5;
    if (sight == Sight::poor) return options;
    options.motion.orientation = Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitX()).toRotationMatrix() *
                                 Eigen::AngleAxisd(0.75, Eigen::Vector3d::UnitY()).toRotationMatrix();
    options.motion.rotation_range = 0.3;
    return options;
  }

  Pose pose(std::size_t i) const { return sequence.pose(static_cast<int>(i)); }
  ImageView view(std::size_t i) const { return view_of(greys[i], PixelFormat::grey8); }

  test::TemporaryFolder folder;
  Sequence sequence;
  std::vector<cv::Mat> greys;
};

const GreyBox& grey_box() {
  static const GreyBox box(40);
  return box;
}

double off_pixels(const Pose& T_true, const Pose& T_found) {
  const Mesh mesh = test::block(kSize);
  return corner_motion({mesh.center().cast<double>(), mesh.radius()}, grey_box().sequence.camera(), T_true, T_found);
}

/// 2 degrees and 5 millimetres away.
Pose near_by(Pose T) {
  T.linear() = T.linear() * Eigen::AngleAxisd(2 / test::kDegrees, Eigen::Vector3d(2, -1, 2).normalized());
  T.translation() += Eigen::Vector3d(0.003, -0.0025, 0.003);
  return T;
}

struct Followed {
  long held = 0;
  double worst = 0;  ///< pixels at a corner, of all frames
  std::vector<Pose> poses;
};

Followed follow(Tracker& tracker, const GreyBox& box) {
  Followed followed;
  for (std::size_t i = 0; i < box.greys.size(); ++i) {
    const FrameResult result = tracker.track(box.view(i));
    followed.held += result.status == Status::held ? 1 : 0;
    followed.worst = std::max(followed.worst, off_pixels(box.pose(i), result.T_camera_object));
    followed.poses.push_back(result.T_camera_object);
  }
  return followed;
}

/// Pictures that the box is not in: white, soft and streaked noise, and its own background.
std::vector<cv::Mat> noise_frames(const Camera& camera) {
  std::vector<cv::Mat> frames;
  for (const double sigma : {0.0, 1.0, 2.0, 4.0}) {
    for (int n = 0; n < 3; ++n) {
      cv::Mat frame(camera.height, camera.width, CV_8U);
      cv::RNG(static_cast<std::uint64_t>(100 * sigma + n + 1)).fill(frame, cv::RNG::UNIFORM, 0, 255);
      if (sigma > 0) cv::GaussianBlur(frame, frame, {}, sigma, n == 2 ? 3 * sigma : sigma);
      cv::normalize(frame, frame, 40, 215, cv::NORM_MINMAX);
      frames.push_back(frame);
    }
  }
  cv::Mat background;
  cv::cvtColor(grey_patches({camera.width, camera.height}, 9), background, cv::COLOR_BGR2GRAY);
  frames.push_back(background);
  return frames;
}

/// The modality alone, looking at a frame of the box.
struct Looking {
  explicit Looking(const cv::Mat& grey, const Mesh& mesh = test::block(kSize))
      : levels(make_levels(grey_box().sequence.camera(), 3)),
        filter(device.impl()),
        view(device.impl(), mesh, view_renderer(mesh, levels, {}), levels, filter),
        image(device.impl(), levels[0].camera, levels, filter),
        extent{mesh.center().cast<double>(), mesh.radius()},
        shape(levels, extent, view),
        edges(device.impl(), levels, extent, mesh, shape, image) {
    image.enqueue_upload(view_of(grey, PixelFormat::grey8), image.region({0, 0, grey.cols, grey.rows}));
    image.wait_for_upload();
  }

  Device device;
  std::vector<Level> levels;
  ImageFilter filter;
  ViewTemplate view;
  DeviceImage image;
  Extent extent;
  DepthView shape;
  EdgeModality edges;
};

}  // namespace

TEST_CASE("edges alone lead back a pose that is some pixels off, and see hardly any in other pictures") {
  Looking looking(grey_box().greys[0]);
  REQUIRE(looking.edges.has_edges());
  const Pose T_true = grey_box().pose(0);
  const EdgeTerms at = looking.edges.linearize(T_true, 0, kClosestEdgeSearch, {});
  REQUIRE(at.found);
  CHECK(at.score() > 0.8);
  CHECK(std::sqrt(at.variance) < 0.6);
  CHECK(looking.edges.coherence(T_true, 1) > 0.6);

  Pose T = near_by(T_true);
  const double before = off_pixels(T_true, T);
  for (int i = 0; i < 15; ++i) {
    const int level = i < 5 ? 1 : 0;
    const EdgeTerms terms = looking.edges.linearize(T, level,
                                                    i < 8    ? kCoarseEdgeSearch
                                                    : i < 11 ? kCloseEdgeSearch
                                                             : kClosestEdgeSearch,
                                                    {});
    REQUIRE(terms.found);
    T = perturbed(T, terms.equations.A.ldlt().solve(terms.equations.h), looking.extent);
  }
  CHECK(before > 5);
  CHECK(off_pixels(T_true, T) < 0.6);

  for (const cv::Mat& noise : noise_frames(grey_box().sequence.camera())) {
    Looking elsewhere(noise);
    CHECK(elsewhere.edges.linearize(T_true, 0, kClosestEdgeSearch, {}).score() < 0.35);
    CHECK(elsewhere.edges.coherence(T_true, 1) < 0.45);
  }
}

TEST_CASE("edges of a frame that look as they are known to are told from others beside them") {
  Looking looking(grey_box().greys[0]);
  const Pose T_true = grey_box().pose(0);
  EdgeMemory memory = looking.edges.no_memory();
  looking.edges.learn(T_true, 0, memory);
  REQUIRE_FALSE(memory.looks.empty());
  const auto known = std::count_if(memory.looks.begin(), memory.looks.end(),
                                   [](const EdgeMemory::Look& look) { return look.faces != 0; });
  CHECK(known > 60);
  looking.edges.start_frame();
  const EdgeTerms with = looking.edges.linearize(T_true, 0, kClosestEdgeSearch, memory);
  CHECK(with.near >= 0.9 * with.lines);
  // The same frame in negative shows all edges the other way round.
  cv::Mat negative;
  cv::bitwise_not(grey_box().greys[0], negative);
  Looking other(negative);
  const EdgeTerms without = other.edges.linearize(T_true, 0, kClosestEdgeSearch, {});
  other.edges.start_frame();
  const EdgeTerms unlike = other.edges.linearize(T_true, 0, kClosestEdgeSearch, memory);
  CHECK(without.score() > 0.8);
  CHECK(unlike.score() < without.score() - 0.2);
}

TEST_CASE("a model without edges is not asked for them") {
  const GreyBox& box = grey_box();
  Tracker tracker(test::ball(0.08F), box.sequence.camera());
  tracker.reset(box.pose(0), box.view(0));
  const FrameResult result = tracker.track(box.view(0));
  CHECK_FALSE(result.edges.asked);
  CHECK(result.edges.lines == 0);
}

TEST_CASE("a plain grey box is held by its edges from a start that is off, and worse without them") {
  const GreyBox& box = grey_box();
  TrackerOptions without;
  without.ablate = {"edges"};
  Tracker tracker(test::block(kSize), box.sequence.camera()), blind(test::block(kSize), box.sequence.camera(), without);
  for (Tracker* each : {&tracker, &blind}) each->reset(near_by(box.pose(0)));
  const Followed by_edges = follow(tracker, box), by_contour = follow(blind, box);
  CHECK(by_edges.held == 40);
  CHECK(by_edges.worst < 1);
  CHECK((by_contour.held < 40 || by_contour.worst > 1.5 * by_edges.worst));

  for (Tracker* each : {&tracker, &blind}) each->reset(box.pose(0), box.view(0));
  const FrameResult result = tracker.track(box.view(0));
  CHECK(result.status == Status::held);
  CHECK(result.edges.asked);
  CHECK(result.edges.lines > 60);
  CHECK(result.edges.near_lines <= result.edges.lines);
  CHECK(result.edges.near_lines > 0.8 * result.edges.lines);
  CHECK(result.edges.score > 0.8);
  CHECK(result.edges.score <= 1);
  CHECK(result.edges.residual < 0.5);
  CHECK_FALSE(blind.track(box.view(0)).edges.asked);
}

TEST_CASE("seen poorly, before clutter as bright as itself, the box is held by its edges and by nothing else") {
  const GreyBox box(25, Sight::poor);
  TrackerOptions without;
  without.ablate = {"edges"};
  Tracker tracker(test::block(kSize), box.sequence.camera()), blind(test::block(kSize), box.sequence.camera(), without);
  for (Tracker* each : {&tracker, &blind}) each->reset(box.pose(0), box.view(0));
  const Followed by_edges = follow(tracker, box), by_contour = follow(blind, box);
  CHECK(by_edges.held == 25);
  CHECK(by_edges.worst < 3);
  CHECK((by_contour.held < 13 || by_contour.worst > 3 * by_edges.worst));
}

TEST_CASE("edges lead to the same poses in both partitions, and every time") {
  const GreyBox& box = grey_box();
  std::vector<Followed> followed;
  for (const Partition partition : {Partition::strips, Partition::groups, Partition::groups}) {
    DeviceOptions options;
    options.partition = partition;
    Tracker tracker(test::block(kSize), box.sequence.camera(), {}, Device(options));
    tracker.reset(box.pose(0));
    followed.push_back(follow(tracker, box));
  }
  for (std::size_t i = 0; i < box.greys.size(); ++i) {
    CAPTURE(i);
    const test::PoseError apart = test::pose_error(followed[0].poses[i], followed[1].poses[i]);
    CHECK(apart.millimetres < 0.05);
    CHECK(apart.degrees < 0.01);
    CHECK(followed[1].poses[i].matrix() == followed[2].poses[i].matrix());
  }
}

TEST_CASE("noise is never held, neither at a first pose nor after the box") {
  const GreyBox& box = grey_box();
  const std::vector<cv::Mat> noise = noise_frames(box.sequence.camera());
  Tracker tracker(test::block(kSize), box.sequence.camera());
  for (std::size_t n = 0; n < noise.size(); ++n) {
    CAPTURE(n);
    tracker.reset(box.pose(0));
    CHECK(tracker.track(view_of(noise[n], PixelFormat::grey8)).status == Status::lost);
  }
  tracker.reset(box.pose(0), box.view(0));
  for (std::size_t i = 0; i < 3; ++i) CHECK(tracker.track(box.view(i)).status == Status::held);
  for (std::size_t n = 0; n < noise.size(); ++n) {
    CAPTURE(n);
    CHECK(tracker.track(view_of(noise[n], PixelFormat::grey8)).status == Status::lost);
  }
}

TEST_CASE("a model whose edges lie some pixels beside the object's stays where it was put") {
  const GreyBox& box = grey_box();
  int kept = 0;
  for (const float off : {0.008F, 0.009F, 0.01F, 0.011F, 0.012F}) {
    CAPTURE(off);
    // The model's top lies about a centimetre too high: some 8 pixels.
    Mesh model = test::block(kSize);
    for (Eigen::Vector3f& p : model.positions) {
      if (p.y() > 0) p.y() += off;
    }
    Tracker tracker(model, box.sequence.camera());
    tracker.reset(box.pose(0));
    const Followed followed = follow(tracker, box);
    CHECK(followed.held == 40);
    // Another pose puts the model's edges on the object's; the first frame decides, often by last digits.
    if (off_pixels(box.pose(0), followed.poses[0]) > 2) continue;
    CHECK(followed.worst < 2);
    ++kept;
  }
  CHECK(kept >= 3);
}

TEST_CASE("a model whose edges lie beside the object's is aligned where the given pose finds far fewer edges") {
  const GreyBox& box = grey_box();
  Mesh model = test::block(kSize);
  for (Eigen::Vector3f& p : model.positions) p.y() *= 1.05F;
  Tracker tracker(model, box.sequence.camera());
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      CAPTURE(axis);
      CAPTURE(side);
      const Pose T_start = box.pose(0) * Eigen::AngleAxisd(side * 0.06, Eigen::Vector3d::Unit(axis));
      tracker.reset(T_start);
      const FrameResult first = tracker.track(box.view(0));
      CHECK(first.status == Status::held);
      CHECK(off_pixels(box.pose(0), first.T_camera_object) < 0.8 * off_pixels(box.pose(0), T_start));
    }
  }
}
