// What the simulated camera adds, what is written, and which options are refused.
#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <future>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <vector>

#include "holdfast/io.hpp"
#include "simulation/light_encoding.hpp"
#include "simulation/sequence.hpp"
#include "simulation/sequence_files.hpp"
#include "simulation/textured_box.hpp"
#include "support/simulated_scene.hpp"

namespace holdfast::simulation {
namespace {

using namespace test;

SequenceOptions everything_on() {
  SequenceOptions options;
  options.camera = {160, 120, 180, 180, 79.5, 59.5, {}};
  options.frames = 6;
  options.samples = 2;
  options.motion_blur = 0.5;
  OccluderOptions cube;
  cube.kind = OccluderKind::cube;
  options.occluders = {OccluderOptions(), cube};
  options.lighting.finish.specular = 0.4;
  options.lighting.lights[0].orbit_radius = 0.3;
  options.background.pan = 2;
  options.sensor.noise = 2;
  options.sensor.shot_noise = 3;
  options.sensor.blur_sigma = 0.6;
  options.sensor.exposure_stops = 0.5;
  options.sensor.white_balance_stops = 0.2;
  options.sensor.gamma_stops = 0.1;
  options.sensor.jpeg_quality = 80;
  return options;
}

bool same(const cv::Mat& a, const cv::Mat& b) { return a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0; }

TEST_CASE("A lens that folds the picture over is refused") {
  SequenceOptions options;
  options.camera.distortion = {-3.0, 0, 0, 0, 0, 0, 0, 0};
  const auto error = error_of([&] { Sequence(textured_box(), options); });
  CHECK(error.says(ErrorCode::camera, {"distortion", "pixel"}));
}

TEST_CASE("Motion blur is centred on the frame's pose and as long as the exposure") {
  const TemporaryFolder folder;
  const Mesh stick = plain_box({0.03, 0.1, 0.001}, {255, 255, 255});
  SequenceOptions options = still_options(folder, kSceneCamera, Pose::Identity());
  options.motion.T_camera_object.clear();
  options.frames = 3;
  constexpr double speed = 8.7;  // pixels a frame; no whole number, so that draws meet the samples evenly
  for (int i = 0; i < 3; ++i) {
    Pose pose = Pose::Identity();
    pose.translation() = Eigen::Vector3d((i - 1) * speed / kSceneCamera.fx, 0, 1);
    options.motion.T_camera_object.push_back(pose);
  }
  struct Moments {
    double mean, variance;
  };
  const auto moments = [&](int frame) {
    const cv::Mat image = Sequence(stick, options).frame(frame);
    double sum = 0, first = 0, second = 0;
    for (int x = 0; x < image.cols; ++x) {
      const double light = linear(image.at<cv::Vec3b>(117, x)[0]);
      sum += light;
      first += light * x;
      second += light * x * x;
    }
    return Moments{first / sum, second / sum - std::pow(first / sum, 2)};
  };
  for (const int frame : {0, 1, 2}) {  // the first and last exposures reach beyond the given poses
    options.motion_blur = 0;
    const Moments sharp = moments(frame);
    const double column = kSceneCamera.cx + (frame - 1) * speed;
    CHECK(std::abs(sharp.mean - column) < 1.0 / 16);  // half the spacing of samples
    for (const double exposure : {0.5, 1.0}) {
      options.motion_blur = exposure;
      const Moments blurred = moments(frame);
      CHECK(std::abs(blurred.mean - column) < 0.04);  // several draws average that
      // A uniform spread over the way moved adds its variance, of which five draws already show all but 4 %.
      CHECK(blurred.variance - sharp.variance == doctest::Approx(std::pow(speed * exposure, 2) / 12).epsilon(0.06));
    }
  }
}

TEST_CASE("Frames depend on the seed alone: not on order, instance or threads") {
  const Mesh box = textured_box();
  SequenceOptions options = everything_on();
  const Sequence sequence(box, options);
  std::vector<cv::Mat> frames;
  for (int i = 0; i < sequence.size(); ++i) frames.push_back(sequence.frame(i));

  const Sequence again(textured_box(), options);
  for (int i = sequence.size() - 1; i >= 0; --i) CHECK(same(again.frame(i), frames[static_cast<std::size_t>(i)]));
  std::vector<std::future<cv::Mat>> parallel;
  for (int i = 0; i < sequence.size(); ++i)
    parallel.push_back(std::async(std::launch::async, [&, i] { return again.frame(i); }));
  for (int i = 0; i < sequence.size(); ++i)
    CHECK(same(parallel[static_cast<std::size_t>(i)].get(), frames[static_cast<std::size_t>(i)]));

  options.seed = 2;
  CHECK_FALSE(same(Sequence(box, options).frame(0), frames[0]));
  CHECK_FALSE(same(frames[0], frames[1]));
}

TEST_CASE("Noise is as strong as asked for and independent from frame to frame") {
  SensorOptions options;
  options.noise = 4;
  const cv::Mat grey(200, 300, CV_32FC3, cv::Scalar::all(linear(100)));
  const auto spread = [](const cv::Mat& image) {
    cv::Scalar mean, deviation;
    cv::meanStdDev(image, mean, deviation);
    return std::pair(mean[1], deviation[1]);
  };
  const Sensor even(options, 1);
  const auto [mean, deviation] = spread(even.record(grey, 0));
  CHECK(mean == doctest::Approx(100).epsilon(0.002));
  CHECK(deviation == doctest::Approx(std::sqrt(16 + 1.0 / 12)).epsilon(0.02));  // with the rounding to whole levels

  options.noise = 0;
  options.shot_noise = 6;
  const Sensor shot(options, 1);
  CHECK(spread(shot.record(grey, 0)).second == doctest::Approx(std::sqrt(36 * 100 / 255.0 + 1.0 / 12)).epsilon(0.02));

  cv::Mat first, second;
  even.record(grey, 0).convertTo(first, CV_64F, 1, -100);
  even.record(grey, 1).convertTo(second, CV_64F, 1, -100);
  CHECK(std::abs(cv::mean(first.mul(second))[1]) / 16 < 0.02);
  cv::Mat shifted = first(cv::Rect(1, 0, 299, 200)).mul(first(cv::Rect(0, 0, 299, 200)));
  CHECK(std::abs(cv::mean(shifted)[1]) / 16 < 0.02);
}

TEST_CASE("Exposure and white balance change the light by the stops asked for") {
  SensorOptions options;
  options.exposure_stops = 1;
  options.change_frames = 100;
  const cv::Mat grey(2, 2, CV_32FC3, cv::Scalar::all(0.2));
  const auto light = [&](int frame, int channel) {
    return linear(Sensor(options, 1).record(grey, frame).at<cv::Vec3b>(0, 0)[channel]);
  };
  CHECK(light(0, 1) == doctest::Approx(0.2).epsilon(0.02));
  CHECK(light(25, 1) == doctest::Approx(0.4).epsilon(0.02));
  CHECK(light(75, 1) == doctest::Approx(0.1).epsilon(0.02));
  options = {};
  options.white_balance_stops = 0.5;
  options.change_frames = 70;
  CHECK(light(25, 2) / light(25, 0) == doctest::Approx(2).epsilon(0.03));
  CHECK(light(25, 1) == doctest::Approx(0.2).epsilon(0.02));
}

TEST_CASE("Files are laid out as evaluation reads them, the same for any number of threads") {
  const Mesh box = textured_box();
  const SequenceOptions options = everything_on();
  const Sequence sequence(box, options);
  const TemporaryFolder folder;
  SequenceFileOptions files;
  files.masks = true;
  files.threads = 1;
  write_sequence(sequence, folder / "one", files);
  files.threads = 3;
  write_sequence(sequence, folder / "three", files);

  const std::vector<Pose> poses = io::load_poses(folder / "one/poses_gt.txt");
  REQUIRE(static_cast<int>(poses.size()) == sequence.size());
  for (int i = 0; i < sequence.size(); ++i) {
    CHECK((poses[static_cast<std::size_t>(i)].matrix() - sequence.pose(i).matrix()).cwiseAbs().maxCoeff() < 1e-8);
    const std::string name = "00000" + std::to_string(i);
    for (const std::string& file : {"frames/" + name + ".jpg", "masks/" + name + ".png"}) {
      CHECK(test::read_file(folder / ("one/" + file)) == test::read_file(folder / ("three/" + file)));
    }
    const SimulatedFrame frame = sequence.make(i);
    CHECK(same(cv::imread((folder / ("one/frames/" + name + ".jpg")).string()), frame.image));
    CHECK(same(cv::imread((folder / ("one/masks/" + name + ".png")).string(), cv::IMREAD_GRAYSCALE),
               frame.occluder_mask));
  }
  CHECK(test::read_file(folder / "one/visible.txt") == test::read_file(folder / "three/visible.txt"));
  const Camera camera = io::load_camera(folder / "one/K.txt");
  CHECK(camera.fx == options.camera.fx);
  CHECK(camera.cy == options.camera.cy);

  const auto again = error_of([&] { write_sequence(sequence, folder / "one", files); });
  CHECK(again.says(ErrorCode::output, {"holds a sequence already", "--overwrite"}));
  files.overwrite = true;
  SequenceOptions shorter = options;
  shorter.frames = 2;
  CHECK(write_sequence(Sequence(box, shorter), folder / "one", files) == 2);
  CHECK(std::distance(std::filesystem::directory_iterator(folder / "one/frames"), {}) == 2);
}

TEST_CASE("An interrupted sequence is a shorter one") {
  const Mesh box = textured_box();
  const TemporaryFolder folder;
  SequenceFileOptions files;
  files.threads = 1;
  int asked = 0;
  files.is_interrupted = [&asked] { return ++asked > 2; };
  CHECK(write_sequence(Sequence(box, everything_on()), folder / "cut", files) == 2);
  CHECK(io::load_poses(folder / "cut/poses_gt.txt").size() == 2);
  CHECK(std::distance(std::filesystem::directory_iterator(folder / "cut/frames"), {}) == 2);
}

TEST_CASE("A picture or a video lies behind the object") {
  const TemporaryFolder folder;
  BackgroundOptions options;
  options.file = plain_background(folder, 90);
  CHECK(Background(options, {64, 48}, 1).at(3).at<cv::Vec3f>(20, 20)[1] == doctest::Approx(linear(90)).epsilon(0.001));

  options.file = folder / "video.avi";
  cv::VideoWriter video(options.file.string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25, {64, 48});
  REQUIRE(video.isOpened());
  for (int i = 0; i < 4; ++i) video.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(40 + 50 * i)));
  video.release();
  const Background moving(options, {64, 48}, 1);
  for (const int frame : {0, 3, 1, 2, 9, 4, 7}) {  // in any order, from the start again at the end
    CAPTURE(frame);
    const double light = moving.at(frame).at<cv::Vec3f>(20, 20)[1];
    CHECK(255 * encoded_from_linear(light) == doctest::Approx(40 + 50 * (frame % 4)).epsilon(0.03));
  }

  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  options.file = folder / "missing.png";
  CHECK(error_of([&] { Background(options, {64, 48}, 1); }).says(ErrorCode::file, {"missing.png", "no such"}));
  options.file = folder.write("broken.avi", "no video");
  CHECK(error_of([&] {
          Background(options, {64, 48}, 1);
        }).says(ErrorCode::file, {"broken.avi", "neither a picture nor a video"}));
}

TEST_CASE("Wrong options are named in one line") {
  const Mesh box = textured_box();
  const auto error_with = [&](auto&& change) {
    SequenceOptions options;
    options.frames = 20;
    change(options);
    return error_of([&] { Sequence(box, options); });
  };
  constexpr ErrorCode wrong = ErrorCode::invalid_argument;
  CHECK(error_with([](SequenceOptions& o) { o.frames = 0; }).says(wrong, {"at least one frame"}));
  CHECK(error_with([](SequenceOptions& o) { o.samples = 0; }).says(wrong, {"samples"}));
  CHECK(error_with([](SequenceOptions& o) { o.motion_blur = 2; }).says(wrong, {"motion blur"}));
  CHECK(error_with([](SequenceOptions& o) { o.motion.speed = 0; }).says(wrong, {"speed"}));
  CHECK(error_with([](SequenceOptions& o) { o.motion.speed = 5000; }).says(wrong, {"cannot move that fast"}));
  CHECK(error_with([](SequenceOptions& o) {
          o.motion.style = MotionStyle::sharp;
          o.motion.turns = 19;
        }).says(wrong, {"19 turns", "20 frames"}));
  CHECK(error_with([](SequenceOptions& o) { o.motion.nearest = 0.05; }).says(wrong, {"nearest distance"}));
  CHECK(
      error_with([](SequenceOptions& o) { o.motion.nearest = 1, o.motion.farthest = 0.5; }).says(wrong, {"farthest"}));
  CHECK(error_with([](SequenceOptions& o) {
          o.motion.T_camera_object = {Pose::Identity()};
        }).says(wrong, {"fewer poses"}));
  CHECK(error_with([](SequenceOptions& o) { o.sensor.jpeg_quality = 101; }).says(wrong, {"JPEG"}));
  CHECK(error_with([](SequenceOptions& o) { o.sensor.noise = -1; }).says(wrong, {"noise"}));
  CHECK(error_of([&] { Sequence(box, SequenceOptions()).frame(1000); }).says(wrong, {"no frame 1000"}));
  CHECK(error_of([] { textured_box({.size = {0.1, 0, 0.1}}); }).says(wrong, {"sides"}));
  Mesh empty;
  CHECK(error_of([&] { Sequence(empty, SequenceOptions()); }).says(ErrorCode::model, {}));
}

}  // namespace
}  // namespace holdfast::simulation
