// The whole tracker on sequences that apps/simulation makes: larger samples, lit surfaces, noise, blur, occluders. It
// shares nothing with the renderer and kernels that are tested.
#include <dlfcn.h>
#include <doctest/doctest.h>

#include <atomic>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "base/tuning.hpp"
#include "device/device_impl.hpp"
#include "holdfast/error.hpp"
#include "holdfast/tracker.hpp"
#include "simulation/sequence.hpp"
#include "support/allocation_counter.hpp"
#include "support/paper_box.hpp"
#include "support/simulated.hpp"

// Every OpenCL object that is created through the loader is counted: these stand in front of the loader's functions.
namespace {
std::atomic<long> created{0};

template <typename Function>
Function next_function(const char* name) {
  ++created;
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}
}  // namespace

extern "C" {
cl_mem clCreateBuffer(cl_context context, cl_mem_flags flags, size_t size, void* host, cl_int* error) {
  return next_function<decltype(&clCreateBuffer)>("clCreateBuffer")(context, flags, size, host, error);
}
cl_kernel clCreateKernel(cl_program program, const char* name, cl_int* error) {
  return next_function<decltype(&clCreateKernel)>("clCreateKernel")(program, name, error);
}
cl_program clCreateProgramWithSource(cl_context context, cl_uint count, const char** strings, const size_t* lengths,
                                     cl_int* error) {
  return next_function<decltype(&clCreateProgramWithSource)>("clCreateProgramWithSource")(context, count, strings,
                                                                                          lengths, error);
}
cl_command_queue clCreateCommandQueue(cl_context context, cl_device_id device, cl_command_queue_properties properties,
                                      cl_int* error) {
  return next_function<decltype(&clCreateCommandQueue)>("clCreateCommandQueue")(context, device, properties, error);
}
}

namespace {

using namespace holdfast;
using simulation::Sequence;
using simulation::SequenceOptions;
using test::box;
using test::paper_camera;
using test::pose_error;
using test::PoseError;
using test::view_of;

/// What tracking a whole sequence from its first true pose gave.
struct Run {
  std::vector<PoseError> errors;
  std::vector<FrameResult> results;
  int held = 0;
  double largest_millimetres() const {
    double largest = 0;
    for (const auto& error : errors) largest = std::max(largest, error.millimetres);
    return largest;
  }
  double largest_degrees() const {
    double largest = 0;
    for (const auto& error : errors) largest = std::max(largest, error.degrees);
    return largest;
  }
};

Run run(const Sequence& sequence, const TrackerOptions& options, const Device& device = Device()) {
  Tracker tracker(box(), sequence.camera(), options, device);
  tracker.reset(sequence.pose(0));
  Run run;
  for (int i = 0; i < sequence.size(); ++i) {
    const cv::Mat frame = sequence.frame(i);
    run.results.push_back(tracker.track(view_of(frame)));
    run.errors.push_back(pose_error(sequence.pose(i), run.results.back().T_camera_object));
    run.held += run.results.back().status == Status::held;
  }
  return run;
}

}  // namespace

TEST_CASE("a box that moves and is lit from one side is held") {
  const Sequence sequence(box(), paper_camera(40, 6, 3));
  const Run result = run(sequence, {});
  CHECK(result.held == sequence.size());
  CHECK(result.largest_millimetres() < 2);
  CHECK(result.largest_degrees() < 0.5);
}

TEST_CASE("fast mode holds it too, a large object at half the resolution") {
  const Sequence sequence(box(), paper_camera(40, 6, 3));
  const Run full = run(sequence, {}), fast = run(sequence, TrackerOptions::fast());
  CHECK(fast.held == sequence.size());
  CHECK(fast.largest_millimetres() < 4);
  CHECK(fast.largest_degrees() < 1);
  const auto size_in = [](const Run& run, std::size_t i) {
    return static_cast<double>(run.results[i].visible_pixels());
  };
  for (std::size_t i = 0; i < full.results.size(); ++i) {
    // Counted in the frame's pixels, whatever the level.
    CHECK(size_in(fast, i) == doctest::Approx(size_in(full, i)).epsilon(0.02));
    // Looked at are fewer.
    if (i > 0) CHECK(fast.results[i].texture.gradient_pixels < 0.5 * full.results[i].texture.gradient_pixels);
  }
}

TEST_CASE("an object that comes near and goes away again is tracked at one resolution and another") {
  SequenceOptions options = paper_camera(40, 6, 3);
  for (int i = 0; i < options.frames; ++i) {
    Pose pose = Pose::Identity();
    pose.linear() = simulation::MotionOptions::default_orientation();
    pose.translation() = Eigen::Vector3d(0, 0, 1.05 + 0.5 * std::cos(2 * M_PI * i / options.frames));
    options.motion.T_camera_object.push_back(pose);
  }
  const Sequence sequence(box(), options);
  const Run changing = run(sequence, TrackerOptions::fast());
  const int limit = tuning_of(TrackerOptions::fast()).most_pixels;
  const auto larger = std::count_if(changing.results.begin(), changing.results.end(),
                                    [&](const FrameResult& result) { return result.visible_pixels() > limit; });
  CHECK(larger > 5);
  CHECK(larger < 35);
  CHECK(changing.held == sequence.size());
  CHECK(changing.largest_millimetres() < 6);
}

TEST_CASE("a box is held behind a white bar, and nothing of the bar is used") {
  SequenceOptions options = paper_camera(40, 4, 5);
  simulation::OccluderOptions bar;
  bar.sweeps = 1;
  options.occluders.push_back(bar);
  const Sequence sequence(box(), options);
  Tracker tracker(box(), sequence.camera());
  tracker.reset(sequence.pose(0));
  double largest_mm = 0, largest_degrees = 0, used = 0, used_occluder = 0, least_visible = 1;
  for (int i = 0; i < sequence.size(); ++i) {
    const auto frame = sequence.make(i);
    const FrameResult result = tracker.track(view_of(frame.image));
    CHECK(result.status == Status::held);
    const PoseError error = pose_error(frame.T_camera_object, result.T_camera_object);
    largest_mm = std::max(largest_mm, error.millimetres);
    largest_degrees = std::max(largest_degrees, error.degrees);
    least_visible = std::min(least_visible, frame.visible_share);
    const PixelMask mask = tracker.pixel_mask();
    for (int y = 0; y < mask.height; ++y) {
      for (int x = 0; x < mask.width; ++x) {
        if (mask.classes[static_cast<std::size_t>(y * mask.width + x)] != static_cast<int>(PixelClass::used)) continue;
        ++used;
        used_occluder += frame.occluder_mask.at<std::uint8_t>(y, x) > 127;
      }
    }
  }
  CHECK(least_visible < 0.8);
  CHECK(largest_mm < 2.5);
  CHECK(largest_degrees < 0.7);
  CHECK(used_occluder / used < 0.005);
}

TEST_CASE("paper mode: one solve a frame follows slow motion, and its tests keep it behind the bar") {
  SequenceOptions options = paper_camera(60, 2, 8);
  simulation::OccluderOptions bar;
  bar.sweeps = 1;
  bar.bar_width = 110;
  options.lighting = simulation::LightingOptions::flat();
  options.occluders.push_back(bar);
  const Sequence sequence(box(), options);
  TrackerOptions untested = TrackerOptions::paper();
  untested.occlusion.gradient_test = untested.occlusion.angle_test = untested.occlusion.magnitude_test = false;
  const Run with = run(sequence, TrackerOptions::paper()), without = run(sequence, untested);
  for (const auto& result : with.results) CHECK(result.iterations == 1);
  CHECK(with.largest_millimetres() < 8);
  CHECK(with.largest_degrees() < 2.5);
  CHECK(without.largest_millimetres() > 2 * with.largest_millimetres());
}

TEST_CASE("two runs give the same bits") {
  const Sequence sequence(box(), paper_camera(8, 6, 11));
  const Run first = run(sequence, {}), second = run(sequence, {});
  for (std::size_t i = 0; i < first.results.size(); ++i) {
    CHECK(std::memcmp(first.results[i].T_camera_object.data(), second.results[i].T_camera_object.data(),
                      16 * sizeof(double)) == 0);
    CHECK(first.results[i].texture.used_pixels == second.results[i].texture.used_pixels);
  }
}

TEST_CASE("the pixel mask decides every row, though poses come from every n-th") {
  const Sequence sequence(box(), paper_camera(6, 3, 19));
  Tracker tracker(box(), sequence.camera());
  tracker.reset(sequence.pose(0));
  for (int i = 0; i < sequence.size(); ++i) {
    const FrameResult result = tracker.track(view_of(sequence.frame(i)));
    REQUIRE(result.status == Status::held);
    const PixelMask mask = tracker.pixel_mask();
    std::array<double, 4> used{};
    for (int y = 0; y < mask.height; ++y) {
      for (int x = 0; x < mask.width; ++x) {
        used[static_cast<std::size_t>(y % 4)] +=
            mask.classes[static_cast<std::size_t>(y * mask.width + x)] == static_cast<int>(PixelClass::used);
      }
    }
    const auto [least, most] = std::minmax_element(used.begin(), used.end());
    CHECK(*least > 0.9 * *most);
    if (i > 0) CHECK(used[0] + used[1] + used[2] + used[3] > 1.8 * result.texture.used_pixels);  // thinned indeed
  }
}

TEST_CASE("both partitions give the same poses and masks within the published tolerance") {
  const Sequence sequence(box(), paper_camera(4, 4, 12));
  DeviceOptions groups;
  groups.partition = Partition::groups;
  Tracker a(box(), sequence.camera()), b(box(), sequence.camera(), {}, Device(groups));
  a.reset(sequence.pose(0));
  b.reset(sequence.pose(0));
  for (int i = 0; i < sequence.size(); ++i) {
    const cv::Mat frame = sequence.frame(i);
    const Pose pose_a = a.track(view_of(frame)).T_camera_object, pose_b = b.track(view_of(frame)).T_camera_object;
    const PoseError difference = pose_error(pose_a, pose_b);
    CHECK(difference.millimetres < 0.05);
    CHECK(difference.degrees < 0.01);
    const PixelMask mask_a = a.pixel_mask(), mask_b = b.pixel_mask();
    double covered = 0, different = 0;
    for (std::size_t p = 0; p < mask_a.classes.size(); ++p) {
      covered += mask_a.classes[p] != 0;
      different += mask_a.classes[p] != mask_b.classes[p];
    }
    CHECK(different <= 0.002 * covered);
  }
}

TEST_CASE("every frame format, strided, from host memory and from a buffer on the caller's own queue") {
  const Sequence sequence(box(), paper_camera(1, 4, 13));
  const cv::Mat bgr = sequence.frame(0);
  cv::Mat wide(bgr.rows, bgr.cols + 9, CV_8UC3, cv::Scalar(1, 2, 3));
  const cv::Mat strided = wide(cv::Rect(4, 0, bgr.cols, bgr.rows));
  bgr.copyTo(strided);
  cv::Mat rgb, rgba, grey;
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  cv::cvtColor(bgr, rgba, cv::COLOR_BGR2RGBA);
  cv::cvtColor(bgr, grey, cv::COLOR_BGR2GRAY);
  // NV12 and YUYV from OpenCV's I420.
  cv::Mat i420, nv12(bgr.rows * 3 / 2, bgr.cols, CV_8UC1), yuyv(bgr.rows, bgr.cols, CV_8UC2);
  cv::cvtColor(bgr, i420, cv::COLOR_BGR2YUV_I420);
  i420.rowRange(0, bgr.rows).copyTo(nv12.rowRange(0, bgr.rows));
  const std::uint8_t* u = i420.ptr(bgr.rows);
  const std::uint8_t* v = u + bgr.rows * bgr.cols / 4;
  for (int y = 0; y < bgr.rows; ++y) {
    for (int x = 0; x < bgr.cols; ++x) {
      const int chroma = (y / 2) * (bgr.cols / 2) + x / 2;
      if (y % 2 == 0) nv12.at<std::uint8_t>(bgr.rows + y / 2, x) = x % 2 ? v[chroma] : u[chroma];
      yuyv.at<cv::Vec2b>(y, x) = {i420.at<std::uint8_t>(y, x), x % 2 ? v[chroma] : u[chroma]};
    }
  }

  // A context and a queue of the caller's own, released before they are used: the device keeps them.
  const cl::Device cl_device = Device().impl().device;
  auto context = std::make_unique<cl::Context>(cl_device);
  auto queue = std::make_unique<cl::CommandQueue>(*context, cl_device);
  const Device own((*context)(), (*queue)());
  Tracker on_host(box(), sequence.camera()), on_buffer(box(), sequence.camera(), {}, own);

  struct Case {
    const char* name;
    ImageView view;
    double millimetres;  ///< from what BGR gives
  };
  const std::vector<Case> cases = {
      {"bgr8", view_of(bgr), 0},
      {"bgr8 strided", view_of(strided), 0},
      {"rgb8", view_of(rgb, PixelFormat::rgb8), 0},
      {"rgba8", view_of(rgba, PixelFormat::rgba8), 0},
      {"grey8", view_of(grey, PixelFormat::grey8), 1.0},
      {"nv12", view_of(nv12, PixelFormat::nv12), 1.0},
      {"yuyv", view_of(yuyv, PixelFormat::yuyv), 1.0},
  };
  Pose T_bgr;
  for (const Case& test : cases) {
    CAPTURE(test.name);
    on_host.reset(sequence.pose(0));
    const FrameResult host = on_host.track(test.view);
    CHECK(host.status == Status::held);
    if (&test == &cases[0]) T_bgr = host.T_camera_object;
    CHECK(pose_error(sequence.pose(0), host.T_camera_object).millimetres < 1.5);
    CHECK(pose_error(T_bgr, host.T_camera_object).millimetres <= test.millimetres);
    if (test.view.format == PixelFormat::grey8) CHECK(host.texture.rows == host.texture.used_pixels);

    const std::size_t bytes = frame_bytes(test.view.format, test.view.height, test.view.stride_bytes);
    const std::size_t offset = 64;
    cl::Buffer buffer(*context, CL_MEM_READ_ONLY, bytes + offset);
    // A strided view's last row may end before its stride does.
    const std::size_t readable = std::strcmp(test.name, "bgr8 strided") == 0 ? bytes - 27 : bytes;
    queue->enqueueWriteBuffer(buffer, CL_FALSE, offset, readable, test.view.data);
    on_buffer.reset(sequence.pose(0));
    const FrameResult device = on_buffer.track(
        DeviceImageView{buffer(), offset, test.view.width, test.view.height, test.view.stride_bytes, test.view.format});
    CHECK(std::memcmp(host.T_camera_object.data(), device.T_camera_object.data(), 16 * sizeof(double)) == 0);
  }
  queue.reset();
  context.reset();
  on_buffer.reset(sequence.pose(0));
  CHECK(on_buffer.track(view_of(bgr)).status == Status::held);
}

TEST_CASE("lens distortion is removed from the frames") {
  SequenceOptions options = paper_camera(5, 3, 14);
  options.camera.distortion = {-0.25, 0.08, 0.001, -0.002, 0, 0, 0, 0};
  const Sequence sequence(box(), options);
  const Run result = run(sequence, {});
  CHECK(result.held == 5);
  CHECK(result.largest_millimetres() < 1.5);
  CHECK(result.largest_degrees() < 0.4);
}

TEST_CASE("pixels of the ideal image that the recorded frame does not show are not compared") {
  SequenceOptions options = paper_camera(6, 3, 17);
  options.camera.distortion = {0.35, 0, 0, 0,
                               0,    0, 0, 0};  // draws the rim outwards: the last dozen of columns are missing
  for (int i = 0; i < options.frames; ++i) {
    Pose T_camera_object = Pose::Identity();
    T_camera_object.linear() = simulation::MotionOptions::default_orientation();
    T_camera_object.translation() = Eigen::Vector3d(0.2 + 0.002 * i, 0.001 * i, 0.7);
    options.motion.T_camera_object.push_back(T_camera_object);
  }
  const Sequence sequence(box(), options);
  for (const TrackerOptions& mode : {TrackerOptions(), TrackerOptions::paper()}) {
    Tracker tracker(box(), sequence.camera(), mode);
    tracker.reset(sequence.pose(0));
    for (int i = 0; i < sequence.size(); ++i) {
      const cv::Mat frame = sequence.frame(i);
      const FrameResult result = tracker.track(view_of(frame));
      CHECK(result.status == Status::held);
      CHECK(pose_error(sequence.pose(i), result.T_camera_object).millimetres < 2);
    }
    const PixelMask mask = tracker.pixel_mask();
    int missing = 0, missing_compared = 0, shown_compared = 0;
    for (int y = 0; y < mask.height; ++y) {
      for (int x = 0; x < mask.width; ++x) {
        const auto pixel_class = static_cast<PixelClass>(mask.classes[static_cast<std::size_t>(y * mask.width + x)]);
        if (pixel_class == PixelClass::not_visible) continue;
        const Eigen::Vector2d source = sequence.camera().distort({x, y});
        const bool shown = source.x() <= mask.width - 1 && source.y() >= 0 && source.y() <= mask.height - 1;
        const bool compared = pixel_class != PixelClass::unusable;
        missing += shown ? 0 : 1;
        // A pixel of the view drawn is looked up where the pose has moved it to since: up to 1.5 pixels away, and
        // distortion stretches that.
        const bool far_out = source.x() > mask.width + 1.5 || source.y() < -2.5 || source.y() > mask.height + 1.5;
        missing_compared += far_out && compared ? 1 : 0;
        shown_compared += shown && compared ? 1 : 0;
      }
    }
    CHECK(missing > 500);
    CHECK(missing_compared == 0);
    CHECK(shown_compared > 10 * missing);
  }
}

TEST_CASE("light, exposure and colour cast between texture and frame") {
  SequenceOptions options = paper_camera(12, 3, 15);
  options.sensor.gain = 0.6;
  options.sensor.white_balance_stops = 0.4;
  options.sensor.exposure_stops = 0.5;
  options.sensor.change_frames = 24;
  const Sequence sequence(box(), options);
  const Run with = run(sequence, {});
  CHECK(with.held == sequence.size());
  CHECK(with.largest_millimetres() < 2);
  CHECK(with.largest_degrees() < 0.5);
  TrackerOptions uncompensated;
  uncompensated.light_compensation = false;
  CHECK(run(sequence, uncompensated).largest_millimetres() > with.largest_millimetres());
}

TEST_CASE("redundancy: one row a pixel where channels repeat each other, and the same pose") {
  const Sequence sequence(box(), paper_camera(1, 3, 16));
  cv::Mat grey, repeated;
  cv::cvtColor(sequence.frame(0), grey, cv::COLOR_BGR2GRAY);
  cv::cvtColor(grey, repeated, cv::COLOR_GRAY2BGR);
  Mesh grey_box = box();
  auto& rgba = grey_box.materials.at(0).texture.rgba;
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    rgba[i] = rgba[i + 1] = rgba[i + 2] =
        static_cast<std::uint8_t>(std::lround(0.299 * rgba[i] + 0.587 * rgba[i + 1] + 0.114 * rgba[i + 2]));
  }
  TrackerOptions all;
  all.light_compensation = false;
  TrackerOptions independent = all;
  independent.occlusion.redundancy = true;
  Tracker tracker_all(grey_box, sequence.camera(), all), tracker_independent(grey_box, sequence.camera(), independent);
  const FrameResult a = tracker_all.refine(view_of(repeated), sequence.pose(0));
  const FrameResult b = tracker_independent.refine(view_of(repeated), sequence.pose(0));
  CHECK(a.texture.rows == 3 * a.texture.used_pixels);
  CHECK(b.texture.rows == b.texture.used_pixels);
  CHECK(pose_error(a.T_camera_object, b.T_camera_object).millimetres < 0.05);
}

TEST_CASE("nothing is allocated in the per-frame path after warm-up") {
  const Sequence sequence(box(), paper_camera(12, 5, 19));
  const std::vector<cv::Mat> frames = test::frames_of(sequence);
  Mesh shape = box();
  for (Material& material : shape.materials) material.texture = {};
  TrackerOptions texture_alone;
  texture_alone.contour = false;
  for (const auto& [options, mesh] : {std::pair{TrackerOptions{}, box()},
                                      {TrackerOptions::paper(), box()},
                                      {TrackerOptions::fast(), box()},
                                      {texture_alone, box()},
                                      {TrackerOptions{}, shape}}) {
    const bool paper = options.quality == Quality::paper;
    CAPTURE(static_cast<int>(options.quality));
    CAPTURE(options.contour);
    CAPTURE(mesh.has_appearance());
    Tracker tracker(mesh, sequence.camera(), options);
    tracker.reset(sequence.pose(0));
    // One solve a frame does not follow this motion: the paper's mode sees the first frame again and again.
    const auto frame = [&, still = paper](std::size_t i) { return view_of(frames[still ? 0 : i]); };
    for (std::size_t i = 0; i < 4; ++i) tracker.track(frame(i));
    const long created_before = created, allocated_before = test::operator_new_count();
    long failed = 0;
    for (std::size_t i = 4; i < frames.size(); ++i) failed += tracker.track(frame(i)).status == Status::lost;
    const long created_after = created, allocated_after = test::operator_new_count();
    CHECK(created_after == created_before);
    // What has no texture is looked for from several starts in every frame, which are counted in short lists.
    CHECK(allocated_after - allocated_before <=
          (mesh.has_appearance() ? 0 : 10 * static_cast<long>(frames.size() - 4)));
    CHECK(created_before > 10);  // the counter counts
    CHECK(failed == 0);
  }
}

TEST_CASE("misuse is one clear error") {
  const Camera camera{320, 240, 400, 400, 159.5, 119.5, {}};
  Tracker tracker(box(), camera);
  const cv::Mat frame(240, 320, CV_8UC3, cv::Scalar(0, 0, 0)), other(200, 320, CV_8UC3, cv::Scalar(0, 0, 0));
  const auto code_of = [](auto&& action) {
    try {
      action();
    } catch (const Error& error) {
      CHECK(std::strlen(error.what()) > 20);
      return static_cast<int>(error.code());
    }
    return -1;
  };
  CHECK(code_of([&] { tracker.track(view_of(frame)); }) == static_cast<int>(ErrorCode::invalid_argument));
  Pose pose = Pose::Identity();
  pose.translation().z() = -1;
  CHECK(code_of([&] { tracker.reset(pose); }) == static_cast<int>(ErrorCode::pose));
  pose.translation() = Eigen::Vector3d(5, 0, 1);
  CHECK(code_of([&] { tracker.reset(pose); }) == static_cast<int>(ErrorCode::pose));
  pose.translation() = Eigen::Vector3d(0, 0, 1);
  pose.linear() *= 1.1;
  CHECK(code_of([&] { tracker.reset(pose); }) == static_cast<int>(ErrorCode::pose));
  pose.linear().setIdentity();
  tracker.reset(pose);
  CHECK(code_of([&] { tracker.track(view_of(other)); }) == static_cast<int>(ErrorCode::image));
  CHECK(code_of([&] {
          tracker.track(ImageView{nullptr, 320, 240, 0, PixelFormat::bgr8});
        }) == static_cast<int>(ErrorCode::image));
  CHECK(code_of([&] {
          tracker.track(ImageView{frame.data, 320, 240, 10, PixelFormat::bgr8});
        }) == static_cast<int>(ErrorCode::image));
  CHECK(code_of([&] { tracker.track(DeviceImageView{}); }) == static_cast<int>(ErrorCode::image));
  CHECK(code_of([&] { Tracker(Mesh{}, camera); }) == static_cast<int>(ErrorCode::model));
  Mesh bare = box();
  bare.materials.clear();
  bare.triangle_materials.clear();
  bare.colors.clear();
  CHECK(code_of([&] { Tracker(bare, camera, TrackerOptions::paper()); }) == static_cast<int>(ErrorCode::model));
  TrackerOptions bad;
  bad.levels = 0;
  CHECK(code_of([&] { Tracker(box(), camera, bad); }) == static_cast<int>(ErrorCode::invalid_argument));
  Camera no_size = camera;
  no_size.width = 0;
  CHECK(code_of([&] { Tracker(box(), no_size); }) == static_cast<int>(ErrorCode::camera));
}
