// The view drawn as a shutter sees it that stays open while the object moves: the kernel against obvious loops, and the
// tracker on sequences whose frames are blurred that way.
#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "device_impl.hpp"
#include "holdfast/tracker.hpp"
#include "image_filter.hpp"
#include "levels.hpp"
#include "reference.hpp"
#include "simulation/sequence.hpp"
#include "simulation/textured_box.hpp"

namespace {

using namespace holdfast;
using reference::Planes;

/// Mean over moments of where a pixel's surface is then, in double precision: the point itself is moved and projected.
/// With `light`, colours (premultiplied by coverage) are averaged as squares.
Planes exposed(const Planes& pixels, const Planes& depth, const Camera& camera, const Twist& twist, int taps,
               bool light) {
  Planes out(pixels.width, pixels.height, 4);
  for (int y = 0; y < pixels.height; ++y) {
    for (int x = 0; x < pixels.width; ++x) {
      const double z = depth.get(x, y, 0);
      if (z <= 0) continue;
      const Eigen::Vector3d p(z * (x - camera.cx) / camera.fx, z * (y - camera.cy) / camera.fy, z);
      const Eigen::Vector3d moved = p + 1e-6 * (twist.head<3>() + twist.tail<3>().cross(p));
      const Eigen::Vector2d flow = 1e6 * (camera.project(moved) - camera.project(p));
      for (int k = 0; k < taps; ++k) {
        const double t = (k + 0.5) / taps - 0.5;
        const double u = std::clamp(x - t * flow.x(), 0.0, pixels.width - 1.0);
        const double v = std::clamp(y - t * flow.y(), 0.0, pixels.height - 1.0);
        const int left = static_cast<int>(u), top = static_cast<int>(v);
        for (int j = 0; j <= 1; ++j) {
          for (int i = 0; i <= 1; ++i) {
            const double weight = (i ? u - left : 1 - u + left) * (j ? v - top : 1 - v + top) / taps;
            for (int c = 0; c < 4; ++c) {
              const double value = pixels.get(left + i, top + j, c);
              out.at(x, y, c) += weight * (light && c < 3 ? value * value : value);
            }
          }
        }
      }
      const double coverage = out.get(x, y, 3);
      for (int c = 0; c < 3 && light && coverage > 0; ++c) {
        out.at(x, y, c) = coverage * std::sqrt(out.get(x, y, c) / coverage);
      }
    }
  }
  return out;
}

void check_kernel(Partition partition, bool light) {
  DeviceOptions device_options;
  device_options.partition = partition;
  const Device device(device_options);
  const Device::Impl& impl = device.impl();
  const Camera camera{96, 64, 110, 97, 40, 35, {}};
  const Level level = make_levels(camera, 1)[0];
  REQUIRE(level.padded_width == 96);
  REQUIRE(level.padded_height == 64);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0, 1);
  Planes pixels(96, 64, 4), depth(96, 64, 1);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 96; ++x) {
      if (x < 10 || x > 80 || y < 8 || y > 50) continue;
      depth.at(x, y, 0) = static_cast<float>(0.5 + 0.2 * uniform(random));
      for (int c = 0; c < 3; ++c) pixels.at(x, y, c) = static_cast<float>(uniform(random));
      pixels.at(x, y, 3) = 1;
    }
  }
  std::vector<float> pixel_memory((level.elements + kGuardFloats) * 4), depth_memory(level.elements + kGuardFloats);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 96; ++x) {
      const auto e = static_cast<std::size_t>(level.layout.origin + y * level.layout.stride + x);
      depth_memory[e] = static_cast<float>(depth.get(x, y, 0));
      for (std::size_t c = 0; c < 4; ++c) {
        pixel_memory[4 * e + c] = static_cast<float>(pixels.get(x, y, static_cast<int>(c)));
      }
    }
  }
  const auto upload = [&](std::vector<float>& memory) {
    return cl::Buffer(impl.context, CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, memory.size() * sizeof(float),
                      memory.data());
  };
  const cl::Buffer in = upload(pixel_memory), z = upload(depth_memory);
  const cl::Buffer out = impl.zeroed_buffer(pixel_memory.size() * sizeof(float));
  Twist twist;
  twist << 0.03, -0.02, 0.05, 0.04, -0.06, 0.1;
  kernel::hf_exposure exposure{};
  for (int i = 0; i < 3; ++i) {
    exposure.v[i] = static_cast<float>(twist(i));
    exposure.w[i] = static_cast<float>(twist(3 + i));
  }
  exposure.fx = 110;
  exposure.fy = 97;
  exposure.cx = 40;
  exposure.cy = 35;
  exposure.taps = 9;
  exposure.light = light ? 1 : 0;
  cl::Kernel kernel = impl.kernel("motion_blur");
  kernel.setArg(0, in);
  kernel.setArg(1, z);
  kernel.setArg(2, level.layout);
  kernel.setArg(3, to_kernel(Rect{0, 0, 96, 64}));
  kernel.setArg(4, exposure);
  kernel.setArg(5, out);
  impl.enqueue_rows(kernel, 96, 64);
  std::vector<float> got(pixel_memory.size());
  impl.queue.enqueueReadBuffer(out, CL_TRUE, 0, got.size() * sizeof(float), got.data());
  const Planes expected = exposed(pixels, depth, camera, twist, 9, light);
  double largest = 0, moved = 0;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 96; ++x) {
      const auto e = static_cast<std::size_t>(level.layout.origin + y * level.layout.stride + x);
      for (std::size_t c = 0; c < 4; ++c) {
        const double reference = expected.get(x, y, static_cast<int>(c));
        largest = std::max(largest, std::abs(reference - static_cast<double>(got[4 * e + c])));
        moved = std::max(moved, std::abs(reference - pixels.get(x, y, static_cast<int>(c))));
      }
    }
  }
  CHECK(largest < 2e-4);
  CHECK(moved > 0.3);
}

simulation::SequenceOptions shutter(double open) {
  simulation::SequenceOptions options;
  options.camera = {512, 384, 600, 600, 255.5, 191.5, {}};
  options.frames = 40;
  options.seed = 11;
  options.motion.speed = 16;
  options.motion.nearest = 0.7;
  options.motion.farthest = 1.0;
  options.motion_blur = open;
  options.sensor.noise = 2;
  return options;
}

struct Run {
  double median_mm = 0;
  int held = 0;
};

Run run(const Mesh& mesh, const simulation::Sequence& sequence, bool motion_blur) {
  TrackerOptions options;
  options.motion_blur = motion_blur;
  Tracker tracker(mesh, sequence.camera(), options);
  tracker.reset(sequence.pose(0));
  std::vector<double> errors;
  Run out;
  for (int i = 1; i < sequence.size(); ++i) {
    const cv::Mat frame = sequence.frame(i);
    const FrameResult result = tracker.track({frame.data, frame.cols, frame.rows, frame.step, PixelFormat::bgr8});
    out.held += result.status == Status::held;
    errors.push_back(1e3 * (sequence.pose(i).translation() - result.T_camera_object.translation()).norm());
  }
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
  out.median_mm = errors[errors.size() / 2];
  return out;
}

}  // namespace

TEST_CASE("motion blur is the mean of the view over the exposure, strips") {
  check_kernel(Partition::strips, false);
  check_kernel(Partition::strips, true);
}
TEST_CASE("motion blur is the mean of the view over the exposure, groups") {
  check_kernel(Partition::groups, false);
  check_kernel(Partition::groups, true);
}

TEST_CASE("a shutter that is open for 0.6 of the time loses no frame, and its blur is measured: errors halve") {
  const Mesh mesh = simulation::textured_box();
  const simulation::Sequence sequence(mesh, shutter(0.6));
  const Run with = run(mesh, sequence, true), without = run(mesh, sequence, false);
  INFO("median error with ", with.median_mm, " mm, without ", without.median_mm, " mm");
  CHECK(with.held == sequence.size() - 1);
  CHECK(with.median_mm < 0.5 * without.median_mm);
  CHECK(with.median_mm < 0.4);
}

TEST_CASE("sharp frames of fast motion stay as accurate with the search for blur as without") {
  const Mesh mesh = simulation::textured_box();
  const simulation::Sequence sequence(mesh, shutter(0));
  const Run with = run(mesh, sequence, true), without = run(mesh, sequence, false);
  INFO("median error with ", with.median_mm, " mm, without ", without.median_mm, " mm");
  CHECK(with.held == sequence.size() - 1);
  CHECK(with.median_mm < 1.2 * without.median_mm);
}

TEST_CASE("reset() forgets the shutter too: a second run of the same tracker gives the same bits") {
  const Mesh mesh = simulation::textured_box();
  const simulation::Sequence sequence(mesh, shutter(0.6));
  Tracker tracker(mesh, sequence.camera(), {});
  std::vector<Pose> first;
  for (int run = 0; run < 2; ++run) {
    tracker.reset(sequence.pose(0));
    for (int i = 1; i < std::min(sequence.size(), 16); ++i) {
      const cv::Mat frame = sequence.frame(i);
      const Pose T = tracker.track({frame.data, frame.cols, frame.rows, frame.step, PixelFormat::bgr8}).T_camera_object;
      if (run == 0) {
        first.push_back(T);
      } else {
        CHECK(T.matrix() == first[static_cast<std::size_t>(i - 1)].matrix());
      }
    }
  }
}
