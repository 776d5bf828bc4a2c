// Detection without a first pose, on frames of the simulator, whose rasterizer and lens know nothing of lib/: from all
// sides, through a lens, in all formats; nothing is found where the object is not; files of features.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "holdfast/detection.hpp"
#include "simulation/textured_box.hpp"
#include "support/check_error.hpp"
#include "support/paper_box.hpp"
#include "support/simulated.hpp"

using namespace holdfast;
using namespace holdfast::test;
using detection::Detector;
using detection::ModelFeatures;
using detection::PoseCandidate;

namespace {

const ModelFeatures& box_features() {
  static const ModelFeatures features(box());
  return features;
}

/// In any orientation, 0.5 to 0.9 m away, in view.
std::vector<Pose> any_poses(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> share(-1, 1);
  std::vector<Pose> poses;
  for (int i = 0; i < count; ++i) {
    Pose T = Pose::Identity();
    Eigen::Quaterniond q(normal(random), normal(random), normal(random), normal(random));
    T.linear() = q.normalized().toRotationMatrix();
    const double z = 0.7 + 0.2 * share(random);
    T.translation() << 0.2 * z * share(random), 0.12 * z * share(random), z;
    poses.push_back(T);
  }
  return poses;
}

simulation::SequenceOptions frames_at(const std::vector<Pose>& poses) {
  simulation::SequenceOptions options = noisy_box(static_cast<int>(poses.size()), 3, 0.5, 0.9);
  options.motion.T_camera_object = poses;
  return options;
}

bool is_near(const Pose& T_true, const Pose& T) {
  const PoseError error = pose_error(T_true, T);
  return error.millimetres < 10 && error.degrees < 5;
}

bool has_near(const std::vector<PoseCandidate>& candidates, const Pose& T_true) {
  return std::any_of(candidates.begin(), candidates.end(),
                     [&](const PoseCandidate& candidate) { return is_near(T_true, candidate.T_camera_object); });
}

/// The other half of the candidates' story: what the tracker makes of them.
int found_frames(const Mesh& mesh, const simulation::Sequence& sequence, const ModelFeatures& features) {
  const Detector detector(features, sequence.camera());
  Tracker tracker(mesh, sequence.camera());
  int found = 0;
  for (int i = 0; i < sequence.size(); ++i) {
    const cv::Mat frame = sequence.frame(i);
    const auto result = detection::start_at(tracker, detector.detect(view_of(frame)), view_of(frame));
    if (!result) continue;
    CAPTURE(i);
    CHECK(result->status == Status::held);
    const PoseError error = pose_error(sequence.pose(i), result->T_camera_object);
    CHECK(error.millimetres < 2);
    CHECK(error.degrees < 1);
    ++found;
  }
  return found;
}

}  // namespace

TEST_CASE("A textured box is found from every side") {
  const simulation::Sequence sequence(box(), frames_at(any_poses(16, 7)));
  CHECK(found_frames(box(), sequence, box_features()) >= 15);
}

TEST_CASE("The tracker goes on from where the object was found") {
  simulation::SequenceOptions options = noisy_box(8, 4, 0.5, 0.9);
  const simulation::Sequence sequence(box(), options);
  const Detector detector(box_features(), options.camera);
  Tracker tracker(box(), options.camera);
  const cv::Mat first = sequence.frame(0);
  REQUIRE(detection::start_at(tracker, detector.detect(view_of(first)), view_of(first), 0.0));
  for (int i = 1; i < sequence.size(); ++i) {
    const cv::Mat frame = sequence.frame(i);
    const FrameResult result = tracker.track(view_of(frame), i / 30.0);
    CHECK(result.status == Status::held);
    CHECK(is_near(sequence.pose(i), result.T_camera_object));
  }
}

TEST_CASE("Nothing is found where the object is not") {
  simulation::BoxOptions other;
  other.seed = 99;
  const Mesh another = simulation::textured_box(other);
  const simulation::Sequence sequence(another, frames_at(any_poses(12, 8)));
  CHECK(found_frames(box(), sequence, box_features()) == 0);

  const cv::Mat noise = clutter(sequence.camera());
  const Detector detector(box_features(), sequence.camera());
  Tracker tracker(box(), sequence.camera());
  CHECK_FALSE(detection::start_at(tracker, detector.detect(view_of(noise)), view_of(noise)));
  const cv::Mat blank(sequence.camera().height, sequence.camera().width, CV_8UC3, cv::Scalar(90, 90, 90));
  CHECK(detector.detect(view_of(blank)).empty());
}

TEST_CASE("A refused candidate leaves the tracker as it was") {
  simulation::SequenceOptions options = noisy_box(3, 4, 0.5, 0.9);
  const simulation::Sequence sequence(box(), options);
  const std::vector<cv::Mat> frames = frames_of(sequence);
  Tracker tracker(box(), options.camera), plain(box(), options.camera);
  PoseCandidate wrong;
  wrong.T_camera_object = sequence.pose(0);
  wrong.T_camera_object.translation().x() += 0.15;
  PoseCandidate behind;
  behind.T_camera_object.translation().z() = -1;
  tracker.reset(sequence.pose(0));
  plain.reset(sequence.pose(0));
  CHECK_FALSE(detection::start_at(tracker, {wrong, behind}, view_of(frames[0])));
  for (const cv::Mat& frame : frames) {
    const FrameResult result = tracker.track(view_of(frame)), usual = plain.track(view_of(frame));
    CHECK(result.T_camera_object.matrix() == usual.T_camera_object.matrix());
  }
}

TEST_CASE("A face that could be tilted either way is a candidate both ways") {
  // The large front alone, far away and tilted: both tilts look nearly the same.
  std::vector<Pose> poses;
  for (const double tilt : {-0.6, -0.4, 0.4, 0.6}) {
    Pose T = Pose::Identity();
    T.linear() = (Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitY()) * Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()))
                     .toRotationMatrix();
    T.translation() << 0.02, 0, 1.6;
    poses.push_back(T);
  }
  const simulation::Sequence sequence(box(), frames_at(poses));
  const Detector detector(box_features(), sequence.camera());
  int both = 0;
  for (int i = 0; i < sequence.size(); ++i) {
    CAPTURE(i);
    const cv::Mat frame = sequence.frame(i);
    const std::vector<PoseCandidate> candidates = detector.detect(view_of(frame));
    REQUIRE_FALSE(candidates.empty());
    double nearest = 180, farthest = 0;
    for (const PoseCandidate& candidate : candidates) {
      const double degrees = pose_error(sequence.pose(i), candidate.T_camera_object).degrees;
      nearest = std::min(nearest, degrees);
      farthest = std::max(farthest, degrees);
    }
    CHECK(nearest < 10);
    both += farthest > 20;
  }
  CHECK(both >= 2);
}

TEST_CASE("Lens distortion is taken out") {
  for (const LensModel lens : {LensModel::polynomial, LensModel::fisheye}) {
    CAPTURE(static_cast<int>(lens));
    simulation::SequenceOptions options = frames_at(any_poses(4, 9));
    options.camera.lens = lens;
    options.camera.distortion = lens == LensModel::polynomial ? std::array<double, 8>{-0.3, 0.1, 0.001, -0.001}
                                                              : std::array<double, 8>{0.05, -0.01, 0.002, 0.0};
    const simulation::Sequence sequence(box(), options);
    CHECK(found_frames(box(), sequence, box_features()) == 4);
  }
}

TEST_CASE("Frames are read in every format") {
  const simulation::Sequence sequence(box(), frames_at(any_poses(1, 10)));
  const Detector detector(box_features(), sequence.camera());
  const cv::Mat bgr = sequence.frame(0);
  cv::Mat other;
  CHECK(has_near(detector.detect(view_of(bgr)), sequence.pose(0)));
  cv::cvtColor(bgr, other, cv::COLOR_BGR2RGB);
  CHECK(has_near(detector.detect(view_of(other, PixelFormat::rgb8)), sequence.pose(0)));
  cv::cvtColor(bgr, other, cv::COLOR_BGR2RGBA);
  CHECK(has_near(detector.detect(view_of(other, PixelFormat::rgba8)), sequence.pose(0)));
  cv::cvtColor(bgr, other, cv::COLOR_BGR2GRAY);
  CHECK(has_near(detector.detect(view_of(other, PixelFormat::grey8)), sequence.pose(0)));
  cv::Mat nv12(other.rows * 3 / 2, other.cols, CV_8U, cv::Scalar(128));
  other.copyTo(nv12.rowRange(0, other.rows));
  CHECK(has_near(detector.detect(view_of(nv12, PixelFormat::nv12)), sequence.pose(0)));
  const std::vector<cv::Mat> channels{other, cv::Mat(other.size(), CV_8U, cv::Scalar(128))};
  cv::Mat yuyv;
  cv::merge(channels, yuyv);
  CHECK(has_near(detector.detect(view_of(yuyv, PixelFormat::yuyv)), sequence.pose(0)));

  const cv::Mat small(100, 100, CV_8UC3);
  CHECK_ERROR(detector.detect(view_of(small)), ErrorCode::image, "100x100", "512x384");
}

TEST_CASE("A large frame is looked at as a smaller one, and its pose is right") {
  simulation::SequenceOptions options = frames_at(any_poses(1, 11));
  options.camera = {1280, 960, 1500, 1500, 639.5, 479.5, {}};
  options.samples = 2;
  const simulation::Sequence sequence(box(), options);
  const Detector detector(box_features(), options.camera);
  const cv::Mat frame = sequence.frame(0);
  CHECK(has_near(detector.detect(view_of(frame)), sequence.pose(0)));
}

TEST_CASE("Features are kept in a file, which is checked when it is read") {
  const TemporaryFolder folder;
  const auto path = folder / "box.views";
  const ModelFeatures& made = box_features();
  made.save(path);
  CHECK(ModelFeatures::load(path, box()).count() == made.count());
  CHECK(ModelFeatures::kept_in(path, box()).count() == made.count());

  const Mesh cube = simulation::lettered_cube(0.1);
  CHECK(detection::model_hash(cube) != detection::model_hash(box()));
  CHECK_ERROR(ModelFeatures::load(path, cube), ErrorCode::file, "box.views", "another model");
  CHECK_ERROR(ModelFeatures::load(folder / "none.views", cube), ErrorCode::file, "none.views");
  Mesh changed = box();
  changed.materials[0].texture.rgba[1000] ^= 1;
  CHECK_ERROR(ModelFeatures::load(path, changed), ErrorCode::file, "another model", "changed");

  const std::string whole = read_file(path);
  folder.write("short.views", whole.substr(0, whole.size() / 2));
  CHECK_ERROR(ModelFeatures::load(folder / "short.views", box()), ErrorCode::file, "short.views", "damaged");
  std::string flipped = whole;
  flipped[flipped.size() - 1000] ^= 4;
  folder.write("flipped.views", flipped);
  CHECK_ERROR(ModelFeatures::load(folder / "flipped.views", box()), ErrorCode::file, "damaged");
  folder.write("foreign.views", "solid box\n");
  CHECK_ERROR(ModelFeatures::load(folder / "foreign.views", box()), ErrorCode::file, "foreign.views",
              "name another file");
  folder.write("empty.views", "");
  CHECK_ERROR(ModelFeatures::load(folder / "empty.views", box()), ErrorCode::file, "empty.views");
  folder.write("endless.views", "holdfast features 1 aa 99999999999999999999 bb\n");
  CHECK_ERROR(ModelFeatures::load(folder / "endless.views", box()), ErrorCode::file, "damaged");
  CHECK_ERROR(made.save(folder / "nowhere/box.views"), ErrorCode::output, "nowhere");
}

TEST_CASE("A model that cannot be recognized is refused") {
  Mesh plain = box();
  plain.materials.clear();
  plain.colors.clear();
  CHECK_ERROR(ModelFeatures{plain}, ErrorCode::model, "neither texture", "guide");
  Mesh blank = box();
  for (Material& material : blank.materials) {
    std::fill(material.texture.rgba.begin(), material.texture.rgba.end(), std::uint8_t{255});
  }
  CHECK_ERROR(ModelFeatures{blank}, ErrorCode::model, "next to no features");
  CHECK_ERROR((Detector{ModelFeatures::none(plain), {640, 480, 600, 600, 319.5, 239.5, {}}}), ErrorCode::model,
              "next to no features");
}

namespace {

/// Poses off by up to 18 degrees, 15 % of the distance and 50 pixels.
Pose off_by_some(const Pose& T, const Camera& camera, std::mt19937& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> share(-1, 1);
  const Eigen::Vector3d axis = Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
  Pose result;
  result.linear() = Eigen::AngleAxisd(18 / kDegrees * share(random), axis) * T.linear();
  const double z = T.translation().z() * (1 + 0.15 * share(random)), way = M_PI * share(random);
  result.translation() =
      T.translation() * z / T.translation().z() + 50 * z / camera.fx * Eigen::Vector3d(std::cos(way), std::sin(way), 0);
  return result;
}

const Mesh& plain_box() {
  static const Mesh mesh = simulation::plain_box({0.2, 0.15, 0.08}, {190, 150, 100});
  return mesh;
}

/// The same shape, of which the tracker knows no colour.
const Mesh& bare_box() {
  static const Mesh mesh = [] {
    Mesh bare = plain_box();
    bare.colors.clear();
    bare.materials.clear();
    bare.texture_coordinates.clear();
    return bare;
  }();
  return mesh;
}

}  // namespace

TEST_CASE("A box without texture is found near where a guide has it") {
  const simulation::Sequence sequence(plain_box(), frames_at(any_poses(10, 21)));
  std::mt19937 random(4);
  Tracker tracker(bare_box(), sequence.camera());
  int found = 0, seen = 0;
  for (int i = 0; i < sequence.size(); ++i) {
    CAPTURE(i);
    const Pose T_true = sequence.pose(i);
    const detection::GuideDetector guide(bare_box(), sequence.camera(), off_by_some(T_true, sequence.camera(), random));
    const cv::Mat frame = sequence.frame(i);
    const std::vector<PoseCandidate> candidates = guide.detect(view_of(frame));
    REQUIRE_FALSE(candidates.empty());
    for (const PoseCandidate& candidate : candidates) CHECK(candidate.score <= 1);
    const auto result = detection::start_near(tracker, candidates, view_of(frame));
    if (!result) continue;
    CHECK(detection::is_still_seen(*result));
    ++seen;
    found += is_near(T_true, result->T_camera_object);
  }
  CHECK(seen == found);
  CHECK(found >= 6);  // most of them, in one frame each, before clutter of all colours
}

TEST_CASE("What a guide leads to does not hang on frames before") {
  const simulation::Sequence sequence(plain_box(), frames_at(any_poses(4, 21)));
  std::mt19937 random(4);
  for (int i = 0; i < sequence.size(); ++i) {
    CAPTURE(i);
    const Pose T_guide = off_by_some(sequence.pose(i), sequence.camera(), random);
    const detection::GuideDetector guide(bare_box(), sequence.camera(), T_guide);
    const cv::Mat frame = sequence.frame(i), noise = clutter(sequence.camera());
    Tracker tracker(bare_box(), sequence.camera()), waiting(bare_box(), sequence.camera());
    const auto at_once = detection::start_near(tracker, guide.detect(view_of(frame)), view_of(frame));
    detection::start_near(waiting, guide.detect(view_of(noise)), view_of(noise));
    const auto later = detection::start_near(waiting, guide.detect(view_of(frame)), view_of(frame));
    REQUIRE(at_once.has_value() == later.has_value());
    if (later) CHECK(later->T_camera_object.matrix() == at_once->T_camera_object.matrix());
  }
}

TEST_CASE("A guide finds nothing where the object is not") {
  // Other boxes, printed ones, in other places than the guide has the plain one.
  const simulation::Sequence sequence(box(), frames_at(any_poses(6, 23)));
  const std::vector<Pose> guides = any_poses(6, 24);
  Tracker tracker(bare_box(), sequence.camera());
  for (int i = 0; i < sequence.size(); ++i) {
    CAPTURE(i);
    const detection::GuideDetector guide(bare_box(), sequence.camera(), guides[static_cast<std::size_t>(i)]);
    const cv::Mat noise = clutter(sequence.camera());
    CHECK_FALSE(detection::start_near(tracker, guide.detect(view_of(noise)), view_of(noise)));
  }
}

TEST_CASE("A guide that cannot be is refused") {
  const Camera camera{320, 240, 300, 300, 159.5, 119.5, {}};
  Pose T = Pose::Identity();
  T.translation() << 0, 0, -1;
  CHECK_ERROR(detection::GuideDetector(box(), camera, T), ErrorCode::pose, "guide", "behind the camera");
  T.translation() << 5, 0, 1;
  CHECK_ERROR(detection::GuideDetector(box(), camera, T), ErrorCode::pose, "guide", "out of the picture");
  T.linear() *= 2;
  CHECK_ERROR(detection::GuideDetector(box(), camera, T), ErrorCode::pose, "rotation");
}

TEST_CASE("A guide's frames are undistorted") {
  simulation::SequenceOptions options = frames_at(any_poses(3, 25));
  options.camera.distortion = {-0.3, 0.1, 0.001, -0.001};
  const simulation::Sequence sequence(plain_box(), options);
  for (int i = 0; i < sequence.size(); ++i) {
    CAPTURE(i);
    const cv::Mat frame = sequence.frame(i);
    const std::vector<PoseCandidate> candidates =
        detection::GuideDetector(bare_box(), options.camera, sequence.pose(i)).detect(view_of(frame));
    REQUIRE_FALSE(candidates.empty());
    const Eigen::Vector2d p_true = options.camera.project(sequence.pose(i).translation());
    CHECK((options.camera.project(candidates[0].T_camera_object.translation()) - p_true).norm() < 8);
  }
}

TEST_CASE("The focal length is estimated from frames of the object, as well as it is said to be") {
  for (const double focal : {450.0, 900.0}) {
    CAPTURE(focal);
    std::vector<Pose> poses = any_poses(10, 31);
    for (Pose& T : poses) T.translation() *= focal / 600;
    simulation::SequenceOptions options = frames_at(poses);
    options.camera.fx = options.camera.fy = focal;
    const simulation::Sequence sequence(box(), options);
    detection::FocalEstimator estimator(box_features(), options.camera.width, options.camera.height);
    CHECK_FALSE(estimator.estimate());
    const cv::Mat away = clutter(options.camera);
    CHECK_FALSE(estimator.add(view_of(away)));
    int seen = 0;
    for (int i = 0; i < sequence.size(); ++i) {
      const cv::Mat frame = sequence.frame(i);
      seen += estimator.add(view_of(frame));
    }
    CHECK(seen >= 8);
    const std::optional<detection::FocalEstimate> estimate = estimator.estimate();
    REQUIRE(estimate);
    CAPTURE(estimate->focal);
    CAPTURE(estimate->sigma);
    CHECK(estimate->frames >= 8);
    CHECK(std::abs(estimate->focal - focal) < 0.03 * focal);
    CHECK(std::abs(estimate->focal - focal) < 3 * estimate->sigma);
    CHECK(estimate->sigma < 0.03 * focal);
  }
}

TEST_CASE("A side is learned once, from a frame that it is held in, where nothing tells it yet") {
  // Two sides, each in two frames.
  std::vector<Pose> poses(4, any_poses(1, 41)[0]);
  poses[0].translation() << 0, 0, 0.6;
  poses[1] = poses[0];
  poses[1].translation().x() += 0.03;
  for (int i = 2; i < 4; ++i) {
    const auto k = static_cast<std::size_t>(i);
    poses[k] = poses[k - 2];
    poses[k].linear() = Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitY()) * poses[k].linear();
  }
  const simulation::Sequence sequence(box(), frames_at(poses));
  FrameResult held;
  held.status = Status::held;
  held.texture.asked = held.texture.holds = true;
  held.texture.gradient_pixels = held.texture.used_pixels = 1000;
  const Mesh& bare = bare_box();
  detection::SightLearner learner(bare, sequence.camera(), ModelFeatures::none(bare), ModelFeatures::none(bare));
  const std::vector<bool> expected{true, false, true, false};
  for (std::size_t i = 0; i < poses.size(); ++i) {
    CAPTURE(i);
    const cv::Mat frame = sequence.frame(static_cast<int>(i));
    held.T_camera_object = poses[i];
    FrameResult lost = held, hidden = held;
    lost.status = Status::lost;
    hidden.texture.used_pixels = 300;
    CHECK_FALSE(learner.look(view_of(frame), lost));
    CHECK_FALSE(learner.look(view_of(frame), hidden));
    CHECK(learner.look(view_of(frame), held) == expected[i]);
  }
  // Places are where the other renderer drew them: the pose comes back from the other frame of each side.
  const Detector detector(learner.seen(), sequence.camera());
  for (const int i : {1, 3}) {
    CAPTURE(i);
    const cv::Mat frame = sequence.frame(i);
    CHECK(has_near(detector.detect(view_of(frame)), sequence.pose(i)));
  }
  // A next run knows both sides, and a textured model's own views tell them.
  for (const bool textured : {false, true}) {
    CAPTURE(textured);
    const ModelFeatures known = textured ? box_features() : ModelFeatures::none(bare);
    const Mesh& mesh = textured ? box() : bare;
    detection::SightLearner next(mesh, sequence.camera(), known,
                                 textured ? ModelFeatures::none(box()) : learner.seen());
    for (int i = 0; i < sequence.size(); ++i) {
      const cv::Mat frame = sequence.frame(i);
      held.T_camera_object = sequence.pose(i);
      CHECK_FALSE(next.look(view_of(frame), held));
    }
  }
  CHECK_THROWS_AS((void)box_features().with(learner.seen()), Error);
}

TEST_CASE("a contour that fits is not enough near a guide where the model's edges are elsewhere") {
  FrameResult result;
  result.status = Status::held;
  result.contour = {.asked = true, .lines = 200, .near_lines = 190, .agreement = 0.9};
  const auto with_edges = [&](int lines, double score) {
    result.edges = {.asked = true, .lines = lines, .score = score};
    return detection::is_still_seen(result);
  };
  CHECK(with_edges(200, 0.6));
  CHECK_FALSE(with_edges(200, 0.3));
  CHECK(with_edges(10, 0.0));  // too few to tell
  result.contour.agreement = 0.5;
  CHECK(with_edges(200, 0.6));
  CHECK_FALSE(with_edges(10, 1.0));
}
