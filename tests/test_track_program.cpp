#include <doctest/doctest.h>
#include <sys/types.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <mutex>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "commands.hpp"
#include "config_file.hpp"
#include "exit_codes.hpp"
#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "simulation/sequence.hpp"
#include "simulation/textured_box.hpp"
#include "support/files.hpp"
#include "track/interruption.hpp"
#include "track/outline.hpp"
#include "track/overlay.hpp"
#include "track/pipeline.hpp"

namespace fs = std::filesystem;
using holdfast::Camera;
using holdfast::ErrorCode;
using holdfast::Mesh;
using holdfast::Pose;
using namespace holdfast::app;
using holdfast::test::error_of;
using holdfast::test::read_file;
using holdfast::test::TemporaryFolder;

namespace {

void sleep_ms(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }

/// Parts that hand numbered one-pixel frames through; a test replaces what it is about.
struct CountingParts {
  explicit CountingParts(int frames) {
    parts.next = [this, frames](Frame& frame) {
      if (read == frames) {
        return false;
      }
      frame.image.create(1, 1, CV_32S);
      frame.image.at<int>(0, 0) = read;
      frame.index = read++;
      return true;
    };
    parts.track = [](TrackedFrame& tracked) { tracked.result.visible_pixels = static_cast<int>(tracked.frame.index); };
    parts.is_pictured = [](std::int64_t) { return false; };
    parts.write = [this](TrackedFrame& tracked) {
      written.push_back(tracked.frame.index);
      results.push_back(tracked.result.visible_pixels);
      pictures.push_back(tracked.pictured ? tracked.frame.image.at<int>(0, 0) : -1);
    };
    parts.is_interrupted = [] { return false; };
  }

  std::atomic<int> read = 0;
  std::vector<std::int64_t> written;
  std::vector<int> results;
  std::vector<int> pictures;
  PipelineParts parts;
};

std::vector<std::int64_t> numbers_up_to(std::int64_t count) {
  std::vector<std::int64_t> numbers;
  for (std::int64_t i = 0; i < count; ++i) {
    numbers.push_back(i);
  }
  return numbers;
}

std::string what_of(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const std::exception& error) {
    return error.what();
  }
}

/// A tiny sequence on disk: a printed box that turns before a background.
class SequenceOnDisk {
 public:
  explicit SequenceOnDisk(int frames) {
    const Mesh box = holdfast::simulation::textured_box();
    holdfast::simulation::SequenceOptions options;
    options.camera = Camera{320, 240, 325, 325, 159.5, 119.5, {}};
    options.frames = frames;
    options.samples = 2;
    options.motion.speed = 2;
    const holdfast::simulation::Sequence sequence(box, options);
    poses = sequence.poses();
    fs::create_directory(folder / "frames");
    for (int i = 0; i < frames; ++i) {
      cv::imwrite((folder / "frames" / (std::to_string(i) + ".png")).string(), sequence.frame(i));
    }
    holdfast::io::save_model(folder / "box.obj", box);
    holdfast::io::save_camera(folder / "camera.yml", options.camera);
    holdfast::io::save_pose(folder / "first.txt", poses.front());
  }

  /// `holdfast track` with the sequence's own inputs and `more`; returns the exit code, throws what the program
  /// reports.
  int track(const std::vector<std::string>& more, const std::string& input = "") const {
    CLI::App app;
    enable_config_file(app);
    int exit_code = kOk;
    holdfast::add_track_command(app, exit_code);
    std::vector<std::string> arguments = {"track",    input.empty() ? (folder / "frames").string() : input,
                                          "--model",  (folder / "box.obj").string(),
                                          "--camera", (folder / "camera.yml").string(),
                                          "--init",   (folder / "first.txt").string(),
                                          "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    std::reverse(arguments.begin(), arguments.end());
    app.parse(arguments);
    return exit_code;
  }

  std::string file(const std::string& name) const { return (folder / name).string(); }

  TemporaryFolder folder;
  std::vector<Pose> poses;
};

struct Row {
  int frame = 0;
  std::string status;
  Pose T_camera_object;
};

std::vector<Row> rows_of(const fs::path& csv) {
  std::vector<Row> rows;
  std::istringstream lines(read_file(csv));
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    std::vector<std::string> fields;
    std::istringstream stream(line);
    for (std::string field; std::getline(stream, field, ',');) {
      fields.push_back(field);
    }
    const auto number = [&](std::size_t i) { return std::stod(fields.at(i)); };
    Row row;
    row.frame = std::stoi(fields.at(0));
    row.status = fields.at(2);
    row.T_camera_object = Pose(Eigen::Quaterniond(number(9), number(6), number(7), number(8)));
    row.T_camera_object.translation() = Eigen::Vector3d(number(3), number(4), number(5));
    rows.push_back(row);
  }
  return rows;
}

int frames_in(const fs::path& video) {
  cv::VideoCapture capture(video.string(), cv::CAP_FFMPEG);
  cv::Mat picture;
  int frames = 0;
  while (capture.read(picture)) {
    ++frames;
  }
  return frames;
}

double length_of(const std::vector<Line>& lines) {
  double length = 0;
  for (const Line& line : lines) {
    length += (line.end - line.begin).norm();
  }
  return length;
}

/// Eight corners, each once a face so that every face has texture coordinates of its own.
Mesh cube(double edge) {
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (const int side : {-1, 1}) {
      const auto first = static_cast<std::uint32_t>(mesh.positions.size());
      for (int corner = 0; corner < 4; ++corner) {
        Eigen::Vector3f p;
        p[axis] = static_cast<float>(side);
        p[(axis + 1) % 3] = corner == 1 || corner == 2 ? 1.0F : -1.0F;
        p[(axis + 2) % 3] = corner >= 2 ? 1.0F : -1.0F;
        mesh.positions.push_back(p * static_cast<float>(edge / 2));
        mesh.colors.push_back({200, 200, 200, 255});
      }
      const auto at = [first, side](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        return side > 0 ? std::array<std::uint32_t, 3>{first + a, first + b, first + c}
                        : std::array<std::uint32_t, 3>{first + a, first + c, first + b};
      };
      mesh.triangles.push_back(at(0, 1, 2));
      mesh.triangles.push_back(at(0, 2, 3));
    }
  }
  return mesh;
}

Mesh sphere(double radius, int rings, int sectors) {
  Mesh mesh;
  for (int i = 0; i <= rings; ++i) {
    for (int j = 0; j < sectors; ++j) {
      const double polar = M_PI * i / rings;
      const double around = 2 * M_PI * j / sectors;
      mesh.positions.push_back((radius * Eigen::Vector3d(std::sin(polar) * std::cos(around),
                                                         std::sin(polar) * std::sin(around), std::cos(polar)))
                                   .cast<float>());
      mesh.colors.push_back({200, 200, 200, 255});
    }
  }
  const auto at = [sectors](int i, int j) { return static_cast<std::uint32_t>(i * sectors + j % sectors); };
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < sectors; ++j) {
      if (i > 0) {
        mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      }
      if (i < rings - 1) {
        mesh.triangles.push_back({at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)});
      }
    }
  }
  return mesh;
}

/// FFmpeg speaks on stderr of files spoiled on purpose.
const int ffmpeg_is_silent = setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);

const Camera kCamera{640, 480, 600, 620, 310.5, 245.5, {}};

}  // namespace

TEST_CASE("the pipeline hands every frame on, in order, each with its own result and picture") {
  CountingParts counting(200);
  const std::set<std::int64_t> pictured = {0, 1, 5, 6, 7, 100, 198, 199};
  counting.parts.is_pictured = [&](std::int64_t ordinal) { return pictured.contains(ordinal); };
  const PipelineReport report = run_pipeline(counting.parts);
  CHECK(report.frames == 200);
  CHECK_FALSE(report.interrupted);
  CHECK_FALSE(report.failure);
  CHECK(counting.written == numbers_up_to(200));
  for (int i = 0; i < 200; ++i) {
    CHECK(counting.results[i] == i);
    CHECK(counting.pictures[i] == (pictured.contains(i) ? i : -1));
  }
}

TEST_CASE("the pipeline's parts work side by side, and none runs far ahead") {
  CountingParts counting(30);
  int farthest_ahead = 0;
  counting.parts.track = [&](TrackedFrame& tracked) {
    sleep_ms(4);
    farthest_ahead = std::max(farthest_ahead, counting.read - static_cast<int>(tracked.frame.index));
  };
  const auto next = counting.parts.next;
  counting.parts.next = [&](Frame& frame) {
    sleep_ms(4);
    return next(frame);
  };
  const auto write = counting.parts.write;
  counting.parts.write = [&](TrackedFrame& tracked) {
    sleep_ms(4);
    write(tracked);
  };
  const PipelineReport report = run_pipeline(counting.parts);
  CHECK(report.frames == 30);
  // 30 x 12 ms one after the other.
  CHECK(report.wall_s < 0.8 * (report.read_s + report.track_s + report.write_s));
  CHECK(report.track_s >= 0.12);
  CHECK(farthest_ahead <= 5);
}

TEST_CASE("frames before a failure are written, and the failure is reported") {
  CountingParts counting(50);
  SUBCASE("reading") {
    const auto next = counting.parts.next;
    counting.parts.next = [&](Frame& frame) {
      if (counting.read == 20) {
        throw std::runtime_error("frame 20 is spoiled");
      }
      return next(frame);
    };
    const PipelineReport report = run_pipeline(counting.parts);
    CHECK(what_of(report.failure) == "frame 20 is spoiled");
    CHECK(counting.written == numbers_up_to(20));
  }
  SUBCASE("tracking") {
    counting.parts.track = [](TrackedFrame& tracked) {
      if (tracked.frame.index == 20) {
        throw std::runtime_error("device lost");
      }
    };
    const PipelineReport report = run_pipeline(counting.parts);
    CHECK(what_of(report.failure) == "device lost");
    CHECK(counting.written == numbers_up_to(20));
  }
  SUBCASE("writing") {
    const auto write = counting.parts.write;
    counting.parts.write = [&](TrackedFrame& tracked) {
      if (tracked.frame.index == 20) {
        throw std::runtime_error("disk full");
      }
      write(tracked);
    };
    const PipelineReport report = run_pipeline(counting.parts);
    CHECK(what_of(report.failure) == "disk full");
    CHECK(counting.written == numbers_up_to(20));
    CHECK(report.frames == 20);
    CHECK(counting.read < 35);  // the others stopped soon
  }
}

TEST_CASE("an interrupted pipeline finishes the frames it has tracked") {
  CountingParts counting(1000000);
  std::atomic<int> tracked_count = 0;
  counting.parts.track = [&](TrackedFrame&) { ++tracked_count; };
  counting.parts.is_interrupted = [&] { return tracked_count == 25; };
  const PipelineReport report = run_pipeline(counting.parts);
  CHECK(report.interrupted);
  CHECK_FALSE(report.failure);
  CHECK(counting.written == numbers_up_to(25));
}

TEST_CASE("a live input drops the oldest frames when tracking is slow, a recorded one none") {
  for (const bool live : {true, false}) {
    CAPTURE(live);
    CountingParts counting(60);
    counting.parts.live = live;
    const auto next = counting.parts.next;
    counting.parts.next = [&](Frame& frame) {
      sleep_ms(1);
      return next(frame);
    };
    std::vector<int> ages;
    counting.parts.track = [&](TrackedFrame& tracked) {
      ages.push_back(counting.read - static_cast<int>(tracked.frame.index));
      sleep_ms(6);
    };
    run_pipeline(counting.parts);
    CHECK(std::is_sorted(counting.written.begin(), counting.written.end()));
    CHECK(counting.written.back() == 59);
    CHECK((counting.written.size() < 60) == live);
    CHECK(*std::max_element(ages.begin(), ages.end()) <= 5);
  }
}

TEST_CASE("signals are remembered while somebody listens") {
  {
    const Interruption interruption;
    CHECK_FALSE(interruption.requested());
    std::raise(SIGTERM);
    CHECK(interruption.requested());
  }
  const Interruption again;
  CHECK_FALSE(again.requested());
  std::raise(SIGINT);
  CHECK(again.requested());
}

TEST_CASE("a cube's outline is the edges of the faces that are seen, without triangulation and texture seams") {
  const Mesh mesh = cube(0.2);
  Outline outline(mesh, kCamera);
  for (const auto& [turn, t] : std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>>{
           {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.8}},
           {{0.5, -0.7, 0.2}, {0.05, -0.03, 0.9}},
           {{-2.0, 1.0, 0.4}, {-0.1, 0.08, 1.2}},
       }) {
    Pose T_camera_object(Eigen::AngleAxisd(
        turn.norm(), turn.norm() > 0 ? Eigen::Vector3d(turn.normalized()) : Eigen::Vector3d::UnitX()));
    T_camera_object.translation() = t;
    // A cube is convex: a face is seen exactly when it faces the camera, an edge when one of its faces is.
    double wanted = 0;
    int faces = 0;
    for (int axis = 0; axis < 3; ++axis) {
      for (const double u : {-0.1, 0.1}) {
        for (const double v : {-0.1, 0.1}) {
          const auto point = [&](double along) {
            Eigen::Vector3d p;
            p[axis] = along;
            p[(axis + 1) % 3] = u;
            p[(axis + 2) % 3] = v;
            return Eigen::Vector3d(T_camera_object * p);
          };
          const auto faces_camera = [&](int normal_axis, double side) {
            const Eigen::Vector3d normal = T_camera_object.linear().col(normal_axis) * side;
            return normal.dot(point(0)) < 0;
          };
          const bool seen = faces_camera((axis + 1) % 3, u) || faces_camera((axis + 2) % 3, v);
          if (seen) {
            wanted += (kCamera.project(point(0.1)) - kCamera.project(point(-0.1))).norm();
            ++faces;
          }
        }
      }
    }
    const std::vector<Line>& lines = outline.lines(T_camera_object);
    CAPTURE(faces);
    CHECK(length_of(lines) == doctest::Approx(wanted).epsilon(0.02));
  }
}

TEST_CASE("a sphere's outline is its silhouette") {
  Outline outline(sphere(0.1, 40, 60), kCamera);
  Pose T_camera_object(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 1, 0).normalized()));
  T_camera_object.translation() = Eigen::Vector3d(0, 0, 0.7);
  const std::vector<Line>& lines = outline.lines(T_camera_object);
  // Tangent cone of half-angle asin(radius / distance).
  const double tangent = std::tan(std::asin(0.1 / 0.7));
  REQUIRE(lines.size() > 20);
  for (const Line& line : lines) {
    for (const Eigen::Vector2d& end : {line.begin, line.end}) {
      const double radius = std::hypot((end.x() - kCamera.cx) / kCamera.fx, (end.y() - kCamera.cy) / kCamera.fy);
      CHECK(radius == doctest::Approx(tangent).epsilon(0.02));
    }
  }
}

TEST_CASE("an outline keeps inside the frame, and is empty where the object is not in view") {
  Outline outline(cube(0.2), kCamera);
  Pose T_camera_object = Pose::Identity();
  T_camera_object.translation() = Eigen::Vector3d(0.45, 0, 0.9);  // half outside
  const std::vector<Line>& cut = outline.lines(T_camera_object);
  CHECK_FALSE(cut.empty());
  for (const Line& line : cut) {
    for (const Eigen::Vector2d& end : {line.begin, line.end}) {
      CHECK(end.x() < kCamera.width + 2);
      CHECK(end.x() > 0);
    }
  }
  T_camera_object.translation() = Eigen::Vector3d(3, 0, 0.9);
  CHECK(outline.lines(T_camera_object).empty());
  T_camera_object.translation() = Eigen::Vector3d(0, 0, -0.9);
  CHECK(outline.lines(T_camera_object).empty());
}

TEST_CASE("pictures show the frame as the tracker sees it: without lens distortion") {
  Camera camera = kCamera;
  camera.distortion = {-0.3, 0.1, 0.002, -0.001, 0, 0, 0, 0};
  const Eigen::Vector2d straight(520, 90);
  const Eigen::Vector2d recorded = camera.distort(straight);
  REQUIRE((recorded - straight).norm() > 5);
  TrackedFrame tracked;
  tracked.frame.image = cv::Mat::zeros(camera.height, camera.width, CV_8UC3);
  cv::circle(tracked.frame.image, {static_cast<int>(recorded.x() * 16), static_cast<int>(recorded.y() * 16)}, 48,
             cv::Scalar::all(255), cv::FILLED, cv::LINE_AA, 4);
  tracked.result.T_camera_object.translation() = Eigen::Vector3d(0, 0, -1);  // nothing to draw
  Overlay overlay(cube(0.2), camera);
  cv::Mat grey;
  cv::cvtColor(overlay.outline_picture(tracked), grey, cv::COLOR_BGR2GRAY);
  REQUIRE(grey.size() == cv::Size(camera.width, camera.height));
  const cv::Moments moments = cv::moments(grey);
  CHECK(std::abs(moments.m10 / moments.m00 - straight.x()) < 0.3);
  CHECK(std::abs(moments.m01 / moments.m00 - straight.y()) < 0.3);
}

TEST_CASE("an overlay tells used pixels from rejected ones by colour, and held from lost") {
  Overlay overlay(cube(0.2), kCamera);
  TrackedFrame tracked;
  tracked.frame.image = cv::Mat(kCamera.height, kCamera.width, CV_8UC3, cv::Scalar::all(128));
  tracked.result.T_camera_object.translation() = Eigen::Vector3d(0, 0, 0.8);
  tracked.mask.width = kCamera.width;
  tracked.mask.height = kCamera.height;
  tracked.mask.classes.assign(static_cast<std::size_t>(kCamera.width) * kCamera.height, 0);
  for (int value = 0; value <= 6; ++value) {  // a column of the picture each
    for (int y = 0; y < kCamera.height; ++y) {
      for (int x = 20 * value; x < 20 * value + 20; ++x) {
        tracked.mask.classes[static_cast<std::size_t>(y) * kCamera.width + x] = static_cast<std::uint8_t>(value);
      }
    }
  }
  const cv::Mat picture = overlay.overlay_picture(tracked).clone();
  REQUIRE(picture.size() == overlay.overlay_size());
  CHECK(picture.cols == 2 * kCamera.width);
  CHECK(picture.rows % 2 == 0);
  const auto color_of = [&](holdfast::PixelClass shown) {
    return cv::Vec3i(picture.at<cv::Vec3b>(100, kCamera.width + 20 * static_cast<int>(shown) + 10));
  };
  using holdfast::PixelClass;
  const cv::Vec3i used = color_of(PixelClass::used);
  CHECK(used[1] > used[0] + 60);
  CHECK(used[1] > used[2] + 60);
  for (const PixelClass rejected :
       {PixelClass::rejected_angle, PixelClass::rejected_magnitude, PixelClass::rejected_vote}) {
    CAPTURE(static_cast<int>(rejected));
    CHECK(color_of(rejected)[2] > color_of(rejected)[1] + 60);
    for (const PixelClass other : {PixelClass::rejected_angle, PixelClass::rejected_magnitude,
                                   PixelClass::rejected_vote, PixelClass::no_gradient, PixelClass::unusable}) {
      CHECK((other == rejected || cv::norm(color_of(rejected) - color_of(other)) > 40));
    }
  }
  const cv::Vec3i background = color_of(PixelClass::not_visible);
  CHECK(background[0] == background[2]);

  // The front face's upper edge, at the left of the picture.
  const Eigen::Vector2d edge = kCamera.project(Eigen::Vector3d(0, -0.1, 0.7));
  const auto line_color = [&](const cv::Mat& of) {
    return cv::Vec3i(of.at<cv::Vec3b>(static_cast<int>(std::lround(edge.y())), static_cast<int>(edge.x())));
  };
  tracked.result.status = holdfast::Status::held;
  const cv::Vec3i held = line_color(overlay.overlay_picture(tracked));
  tracked.result.status = holdfast::Status::lost;
  const cv::Vec3i lost = line_color(overlay.overlay_picture(tracked));
  CHECK(held[1] > held[2] + 60);
  CHECK(lost[2] > lost[1] + 60);
}

TEST_CASE("track follows a sequence and writes all that is asked for") {
  const SequenceOnDisk sequence(12);
  const int exit_code =
      sequence.track({"--poses", sequence.file("poses.csv"), "--tum", sequence.file("poses.txt"), "--json",
                      sequence.file("run.json"), "--overlay", sequence.file("overlay.mp4"), "--contact-sheet",
                      sequence.file("sheet.png"), "--contact-frames", "4", "--require-held"});
  CHECK(exit_code == kOk);
  const std::vector<Row> rows = rows_of(sequence.folder / "poses.csv");
  REQUIRE(rows.size() == 12);
  for (int i = 0; i < 12; ++i) {
    CAPTURE(i);
    CHECK(rows[i].frame == i);
    CHECK(rows[i].status == "held");
    const Pose error = rows[i].T_camera_object.inverse() * sequence.poses[i];
    CHECK(error.translation().norm() < 0.01);
    CHECK(holdfast::rotation_angle(error.linear()) < 2 * M_PI / 180);
  }
  const nlohmann::json run = nlohmann::json::parse(read_file(sequence.folder / "run.json"));
  CHECK(run["frames"].size() == 12);
  CHECK(run["summary"]["complete"] == true);
  CHECK(run["run"]["camera"]["fx"] == 325);
  CHECK(frames_in(sequence.folder / "overlay.mp4") == 12);
  CHECK_FALSE(cv::imread(sequence.file("sheet.png")).empty());
  CHECK(holdfast::io::load_poses(sequence.folder / "poses.txt").size() == 12);
}

TEST_CASE("the same poses come out whatever else is written, and from run to run") {
  const SequenceOnDisk sequence(6);
  REQUIRE(sequence.track({"--poses", sequence.file("a.csv")}) == kOk);
  REQUIRE(sequence.track({"--poses", sequence.file("b.csv"), "--overlay", sequence.file("o.mp4")}) == kOk);
  const std::vector<Row> a = rows_of(sequence.folder / "a.csv");
  const std::vector<Row> b = rows_of(sequence.folder / "b.csv");
  REQUIRE(a.size() == 6);
  REQUIRE(b.size() == 6);
  for (std::size_t i = 0; i < 6; ++i) {
    CHECK(a[i].T_camera_object.matrix() == b[i].T_camera_object.matrix());
  }
}

TEST_CASE("an object that is not there is lost, and --require-held tells it by the exit code") {
  const SequenceOnDisk sequence(4);
  for (int i = 1; i < 4; ++i) {
    cv::Mat noise(240, 320, CV_8UC3);
    cv::randu(noise, 0, 255);
    cv::imwrite(sequence.file("frames/" + std::to_string(i) + ".png"), noise);
  }
  CHECK(sequence.track({"--poses", sequence.file("poses.csv")}) == kOk);
  const std::vector<Row> rows = rows_of(sequence.folder / "poses.csv");
  REQUIRE(rows.size() == 4);
  CHECK(rows[0].status == "held");
  CHECK(rows[3].status == "lost");
  CHECK(sequence.track({"--require-held"}) == kLost);
}

TEST_CASE("options come from a configuration file, the command line wins") {
  const SequenceOnDisk sequence(5);
  sequence.folder.write("run.toml", "stop = 4\nstride = 2\nposes = \"" + sequence.file("poses.csv") + "\"\n");
  REQUIRE(sequence.track({"--config", sequence.file("run.toml")}) == kOk);
  std::vector<Row> rows = rows_of(sequence.folder / "poses.csv");
  REQUIRE(rows.size() == 2);
  CHECK(rows[1].frame == 2);
  REQUIRE(sequence.track({"--config", sequence.file("run.toml"), "--stride", "1"}) == kOk);
  CHECK(rows_of(sequence.folder / "poses.csv").size() == 4);
}

TEST_CASE("an interrupted run leaves complete files") {
  const SequenceOnDisk sequence(3);
  for (int i = 3; i < 2000; ++i) {  // goes on without motion for longer than anybody waits
    fs::create_hard_link(sequence.file("frames/2.png"), sequence.file("frames/" + std::to_string(i) + ".png"));
  }
  std::atomic<bool> sent = false;
  std::thread impatient([&] {
    for (int waited_ms = 0; waited_ms < 60000 && !sent; waited_ms += 5) {
      sleep_ms(5);
      if (fs::exists(sequence.folder / "poses.csv") && rows_of(sequence.folder / "poses.csv").size() >= 5) {
        sent = true;
        kill(getpid(), SIGINT);
      }
    }
  });
  const int exit_code =
      sequence.track({"--poses", sequence.file("poses.csv"), "--tum", sequence.file("poses.txt"), "--json",
                      sequence.file("run.json"), "--overlay", sequence.file("overlay.mp4")});
  impatient.join();
  REQUIRE(sent);
  CHECK(exit_code == kInterrupted);
  const std::size_t rows = rows_of(sequence.folder / "poses.csv").size();
  CHECK(rows >= 5);
  CHECK(rows < 2000);
  CHECK(read_file(sequence.folder / "poses.csv").ends_with("\n"));
  const nlohmann::json run = nlohmann::json::parse(read_file(sequence.folder / "run.json"));
  CHECK(run["frames"].size() == rows);
  CHECK(run["summary"]["complete"] == false);
  CHECK(static_cast<std::size_t>(frames_in(sequence.folder / "overlay.mp4")) == rows);
}

TEST_CASE("what ends a run early leaves the poses so far in the files") {
  const SequenceOnDisk sequence(6);
  const std::vector<std::string> outputs = {"--poses", sequence.file("poses.csv")};
  SUBCASE("a frame of another size") {
    cv::imwrite(sequence.file("frames/4.png"), cv::Mat(100, 100, CV_8UC3, cv::Scalar::all(9)));
    CHECK(error_of([&] { sequence.track(outputs); }).says(ErrorCode::image, {"frame 4", "100x100", "320x240"}));
    CHECK(rows_of(sequence.folder / "poses.csv").size() == 4);
  }
  SUBCASE("an unreadable image") {
    sequence.folder.write("frames/3.png", "text");
    CHECK(error_of([&] { sequence.track(outputs); }).says(ErrorCode::file, {"frame 3", "3.png"}));
    CHECK(rows_of(sequence.folder / "poses.csv").size() == 3);
  }
  SUBCASE("a video that ends mid-frame") {
    {
      cv::VideoWriter video(sequence.file("v.avi"), cv::CAP_FFMPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25,
                            {320, 240});
      for (int i = 0; i < 6; ++i) {
        video.write(cv::imread(sequence.file("frames/" + std::to_string(i) + ".png")));
      }
    }
    const std::string whole = read_file(sequence.folder / "v.avi");
    sequence.folder.write("cut.avi", whole.substr(0, whole.size() * 6 / 10));
    CHECK(sequence.track(outputs, sequence.file("v.avi")) == kOk);
    CHECK(rows_of(sequence.folder / "poses.csv").size() == 6);
    CHECK(sequence.track(outputs, sequence.file("cut.avi")) == kInput);
    const std::size_t rows = rows_of(sequence.folder / "poses.csv").size();
    CHECK(rows >= 2);
    CHECK(rows < 6);
  }
}

TEST_CASE("runs that cannot succeed are refused before they overwrite anything") {
  const SequenceOnDisk sequence(2);
  const fs::path kept = sequence.folder.write("kept.csv", "earlier results");
  const auto error = [&](std::vector<std::string> more, const std::string& input = "") {
    more.insert(more.end(), {"--poses", kept.string()});
    return error_of([&] { sequence.track(more, input); });
  };
  CHECK(error({"--tum", sequence.file("none/a.txt")}).says(ErrorCode::output, {"none/a.txt", "does not exist"}));
  CHECK(error({"--tum", sequence.file("./kept.csv")}).says(ErrorCode::invalid_argument, {"two results", "kept.csv"}));
  CHECK(error({"--tum", sequence.file("first.txt")}).says(ErrorCode::invalid_argument, {"is an input", "first.txt"}));
  CHECK(error({"--start", "9"}).says(ErrorCode::invalid_argument, {"--start 9"}));
  CHECK(error({"--contact-sheet", sequence.file("s.png"), "--contact-frames", "0"})
            .says(ErrorCode::invalid_argument, {"--contact-frames 0"}));
  CHECK(error({}, sequence.file("none")).says(ErrorCode::file, {"none"}));
  holdfast::io::save_pose(sequence.folder / "first.txt", Pose(Eigen::Translation3d(0, 0, -1)));
  CHECK(error({}).says(ErrorCode::pose, {"behind the camera"}));
  CHECK(read_file(kept) == "earlier results");
}
