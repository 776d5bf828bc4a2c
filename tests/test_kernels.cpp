// Every kernel against the obvious loops of reference.hpp, on both partitions, on odd sizes and random images.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>

#include "device_impl.hpp"
#include "holdfast/image_view.hpp"
#include "image_filter.hpp"
#include "levels.hpp"
#include "occlusion.hpp"
#include "reference.hpp"
#include "shared.h"

namespace {

using namespace holdfast;
using reference::Planes;

struct Size {
  int width, height;
};
const std::vector<Size> kSmall = {{1, 1}, {17, 13}};
const std::vector<Size> kLarge = {{640, 480}};

Device make_device(Partition partition) {
  DeviceOptions options;
  options.partition = partition;
  return Device(options);
}

/// Both, unless HOLDFAST_TEST_PARTITION names one: rusticl takes many minutes to compile strips.
std::vector<Partition> partitions() {
  const char* only = std::getenv("HOLDFAST_TEST_PARTITION");
  if (only == nullptr) return {Partition::strips, Partition::groups};
  REQUIRE(std::string(only) == "groups");
  return {Partition::groups};
}

Level make_level(Size size) {
  Camera camera{size.width,        size.height, 1.1 * size.width + 3, 0.9 * size.width + 5, 0.4 * size.width,
                0.6 * size.height, {}};
  return make_levels(camera, 1)[0];
}

Rect whole(const Level& level) { return {0, 0, level.padded_width, level.padded_height}; }

/// Random interleaved pixels, premultiplied by a coverage that is often 0 or 1.
Planes random_pixels(Size size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  Planes planes(size.width, size.height, 4);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double draw = uniform(random);
      const double coverage = draw < 0.2 ? 0 : draw < 0.8 ? 1 : uniform(random);
      for (int c = 0; c < 3; ++c) planes.at(x, y, c) = static_cast<float>(coverage * uniform(random));
      planes.at(x, y, 3) = static_cast<float>(coverage);
    }
  }
  return planes;
}

/// Memory of a level with `channels` floats a pixel, zero outside the image.
std::vector<float> to_memory(const Planes& planes, const Level& level) {
  const auto channels = static_cast<std::size_t>(planes.channels);
  std::vector<float> memory((level.elements + kGuardFloats) * channels, 0.0f);
  for (int y = 0; y < planes.height; ++y) {
    for (int x = 0; x < planes.width; ++x) {
      const auto e = static_cast<std::size_t>(level.layout.origin + y * level.layout.stride + x);
      for (int c = 0; c < planes.channels; ++c) {
        memory[e * channels + static_cast<std::size_t>(c)] = static_cast<float>(planes.get(x, y, c));
      }
    }
  }
  return memory;
}

/// The same, a plane a channel.
std::vector<float> to_plane_memory(const Planes& planes, const Level& level) {
  std::vector<float> memory(level.elements * static_cast<std::size_t>(planes.channels) + kGuardFloats, 0.0f);
  for (int y = 0; y < planes.height; ++y) {
    for (int x = 0; x < planes.width; ++x) {
      const auto e = static_cast<std::size_t>(level.layout.origin + y * level.layout.stride + x);
      for (int c = 0; c < planes.channels; ++c) {
        memory[e + static_cast<std::size_t>(c) * level.elements] = static_cast<float>(planes.get(x, y, c));
      }
    }
  }
  return memory;
}

template <typename T>
cl::Buffer upload(const Device::Impl& device, std::vector<T>& values) {
  return cl::Buffer(device.context, CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, values.size() * sizeof(T), values.data());
}

template <typename T>
std::vector<T> download(const Device::Impl& device, const cl::Buffer& buffer, std::size_t count) {
  std::vector<T> values(count);
  device.queue.enqueueReadBuffer(buffer, CL_TRUE, 0, count * sizeof(T), values.data());
  return values;
}

double largest_difference(const std::vector<float>& memory, const Level& level, const Planes& expected) {
  double largest = 0;
  for (int y = 0; y < expected.height; ++y) {
    for (int x = 0; x < expected.width; ++x) {
      const auto e = static_cast<std::size_t>(level.layout.origin + y * level.layout.stride + x);
      for (int c = 0; c < expected.channels; ++c) {
        const auto i = e * static_cast<std::size_t>(expected.channels) + static_cast<std::size_t>(c);
        largest = std::max(largest, std::abs(static_cast<double>(memory[i]) - expected.get(x, y, c)));
      }
    }
  }
  return largest;
}

void check_blur(Size size) {
  for (const Partition partition : partitions()) {
    const Device device = make_device(partition);
    const Device::Impl& impl = device.impl();
    const Level level = make_level(size);
    const double sigma = 1.2;
    ImageFilter filter(impl, sigma);
    const Planes in = random_pixels(size, 7);
    auto memory = to_memory(in, level);
    const cl::Buffer in_buffer = upload(impl, memory);
    for (const int left : {0, 4}) {  // blocks of the whole image, and blocks that start and end elsewhere
      const Rect rect{left, left, level.padded_width - 2 * left, level.padded_height - 2 * left};
      const cl::Buffer blurred = impl.zeroed_buffer((level.elements + kGuardFloats) * HF_PIXEL * sizeof(float));
      filter.enqueue_blur(in_buffer, level, rect, blurred);
      const auto out = download<float>(impl, blurred, level.elements * 4);
      Planes expected = reference::blurred(in, sigma);
      for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) {
          const bool inside = x >= left && y >= left && x < rect.x + rect.width && y < rect.y + rect.height;
          for (int c = 0; c < 4 && !inside; ++c) expected.at(x, y, c) = 0;
        }
      }
      CHECK(largest_difference(out, level, expected) < 2e-5);
    }
  }
}

void check_halve(Size size) {
  for (const Partition partition : partitions()) {
    const Device device = make_device(partition);
    const Device::Impl& impl = device.impl();
    Camera camera{size.width, size.height, 100, 100, 0, 0, {}};
    const auto levels = make_levels(camera, 2);
    ImageFilter filter(impl, 1.0);
    const Planes in = random_pixels(size, 9);
    auto memory = to_memory(in, levels[0]);
    const cl::Buffer in_buffer = upload(impl, memory);
    const std::size_t out_size = (levels[1].elements + kGuardFloats) * 4;
    const cl::Buffer out_buffer = impl.zeroed_buffer(out_size * sizeof(float));
    filter.enqueue_halve(in_buffer, levels[0], whole(levels[1]), levels[1], out_buffer);
    Planes expected(levels[1].width, levels[1].height, 4);
    for (int y = 0; y < expected.height; ++y) {
      for (int x = 0; x < expected.width; ++x) {
        for (int c = 0; c < 4; ++c) {
          expected.at(x, y, c) = (in.get(2 * x, 2 * y, c) + in.get(2 * x + 1, 2 * y, c) + in.get(2 * x, 2 * y + 1, c) +
                                  in.get(2 * x + 1, 2 * y + 1, c)) /
                                 4;
        }
      }
    }
    CHECK(largest_difference(download<float>(impl, out_buffer, out_size), levels[1], expected) < 1e-6);
  }
}

std::array<double, 3> expected_rgb(const std::vector<std::uint8_t>& f, PixelFormat format, std::size_t stride,
                                   int height, int x, int y) {
  const auto byte = [&](std::size_t row, int column) {
    return static_cast<double>(f[row * stride + static_cast<std::size_t>(column)]);
  };
  const auto row = static_cast<std::size_t>(y);
  const auto from_yuv = [](double luma, double u, double v) {
    // BT.601, limited range, from its definition: Kr = 0.299, Kb = 0.114.
    const double kr = 0.299, kb = 0.114, kg = 1 - kr - kb;
    const double l = (luma - 16) / 219, pb = (u - 128) / 224, pr = (v - 128) / 224;
    const double r = l + 2 * (1 - kr) * pr, b = l + 2 * (1 - kb) * pb, g = (l - kr * r - kb * b) / kg;
    return std::array<double, 3>{std::clamp(r, 0.0, 1.0), std::clamp(g, 0.0, 1.0), std::clamp(b, 0.0, 1.0)};
  };
  switch (format) {
    case PixelFormat::bgr8:
      return {byte(row, 3 * x + 2) / 255, byte(row, 3 * x + 1) / 255, byte(row, 3 * x) / 255};
    case PixelFormat::rgb8:
      return {byte(row, 3 * x) / 255, byte(row, 3 * x + 1) / 255, byte(row, 3 * x + 2) / 255};
    case PixelFormat::rgba8:
      return {byte(row, 4 * x) / 255, byte(row, 4 * x + 1) / 255, byte(row, 4 * x + 2) / 255};
    case PixelFormat::grey8:
      return {byte(row, x) / 255, 0, 0};
    case PixelFormat::nv12: {
      const auto chroma = static_cast<std::size_t>(height + y / 2);
      return from_yuv(byte(row, x), byte(chroma, x / 2 * 2), byte(chroma, x / 2 * 2 + 1));
    }
    case PixelFormat::yuyv:
      return from_yuv(byte(row, 2 * x), byte(row, x / 2 * 4 + 1), byte(row, x / 2 * 4 + 3));
  }
  return {};
}

void check_conversion(Size size) {
  const std::array<const char*, 6> names{"convert_bgr8",  "convert_rgb8", "convert_rgba8",
                                         "convert_grey8", "convert_nv12", "convert_yuyv"};
  for (const Partition partition : partitions()) {
    const Device device = make_device(partition);
    const Device::Impl& impl = device.impl();
    const Level level = make_level(size);
    for (int format_index = 0; format_index < 6; ++format_index) {
      const auto format = static_cast<PixelFormat>(format_index);
      const bool paired = format == PixelFormat::nv12 || format == PixelFormat::yuyv;
      if (paired && (size.width % 2 || size.height % 2)) continue;  // these formats have no odd sizes
      CAPTURE(names[static_cast<std::size_t>(format_index)]);
      const std::size_t stride = packed_stride(format, size.width) + 5, offset = 3;
      std::mt19937 random(11);
      std::vector<std::uint8_t> frame(frame_bytes(format, size.height, stride));
      for (auto& byte : frame) byte = static_cast<std::uint8_t>(random());
      std::vector<std::uint8_t> shifted(offset, 0);
      shifted.insert(shifted.end(), frame.begin(), frame.end());
      const cl::Buffer frame_buffer = upload(impl, shifted);
      for (const bool distorted : {false, true}) {
        kernel::hf_frame f{};
        f.width = size.width;
        f.height = size.height;
        f.offset = static_cast<int>(offset);
        f.stride = static_cast<int>(stride);
        f.distorted = distorted ? 1 : 0;
        Camera camera = level.camera;
        camera.distortion = {-0.2, 0.05, 0.002, -0.001, 0.01, 0.01, -0.02, 0.003};
        f.fx = static_cast<float>(camera.fx);
        f.fy = static_cast<float>(camera.fy);
        f.cx = static_cast<float>(camera.cx);
        f.cy = static_cast<float>(camera.cy);
        float* k[] = {&f.k1, &f.k2, &f.p1, &f.p2, &f.k3, &f.k4, &f.k5, &f.k6};
        for (std::size_t i = 0; i < 8; ++i) *k[i] = static_cast<float>(camera.distortion[i]);
        cl::Kernel kernel = impl.kernel(names[static_cast<std::size_t>(format_index)]);
        const cl::Buffer out = impl.zeroed_buffer((level.elements + kGuardFloats) * 4 * sizeof(float));
        kernel.setArg(0, frame_buffer);
        kernel.setArg(1, f);
        kernel.setArg(2, to_kernel(whole(level)));
        kernel.setArg(3, level.layout);
        kernel.setArg(4, out);
        impl.enqueue_rows(kernel, level.padded_width, level.padded_height);
        const auto got = download<float>(impl, out, level.elements * 4);
        double largest = 0;
        int at_border = 0;
        for (int y = 0; y < level.padded_height; ++y) {
          for (int x = 0; x < level.padded_width; ++x) {
            std::array<double, 4> expected{};
            double tolerance = 2e-6;
            if (x < size.width && y < size.height) {
              if (!distorted) {
                const auto rgb = expected_rgb(frame, format, stride, size.height, x, y);
                expected = {rgb[0], rgb[1], rgb[2], 1};
              } else {
                // Camera::distort is checked against its own formula in test_pose_camera.
                const Eigen::Vector2d p = camera.distort({static_cast<double>(x), static_cast<double>(y)});
                const double margin = std::min({p.x(), p.y(), size.width - 1 - p.x(), size.height - 1 - p.y()});
                if (std::abs(margin) < 1e-3) {
                  ++at_border;
                  continue;
                }
                if (margin > 0) {
                  const int x0 = static_cast<int>(p.x()), y0 = static_cast<int>(p.y());
                  const double u = p.x() - x0, v = p.y() - y0;
                  for (int j = 0; j <= 1; ++j) {
                    for (int i = 0; i <= 1; ++i) {
                      const auto rgb =
                          expected_rgb(frame, format, stride, size.height, std::min(x0 + i, size.width - 1),
                                       std::min(y0 + j, size.height - 1));
                      for (std::size_t c = 0; c < 3; ++c) expected[c] += (i ? u : 1 - u) * (j ? v : 1 - v) * rgb[c];
                    }
                  }
                  expected[3] = 1;
                  tolerance = 1e-3;  // float positions of up to 640, 2^-14 pixel apart, on white noise
                }
              }
            }
            const auto e = static_cast<std::size_t>(level.layout.origin + y * level.layout.stride + x);
            for (std::size_t c = 0; c < 4; ++c) {
              largest = std::max(largest, std::abs(static_cast<double>(got[e * 4 + c]) - expected[c]) / tolerance);
            }
          }
        }
        CHECK(largest < 1);
        CHECK(at_border <= 2 * (size.width + size.height));
      }
    }
  }
}

/// Everything that the tests and the constraints read, random but plausible, and the same in double.
struct Scene {
  Size size;
  Level level;
  Planes value, dx, dy, depth, frame, features, cells;  // features: the frame's values and central differences
  std::vector<std::uint8_t> usable;
  kernel::hf_rect tiles{};
  reference::Camera camera{};

  Scene(Size s, unsigned seed)
      : size(s),
        level(make_level(s)),
        value(s.width, s.height, 3),
        dx(s.width, s.height, 3),
        dy(s.width, s.height, 3),
        depth(s.width, s.height, 1),
        frame(s.width, s.height, HF_PIXEL),
        features(s.width, s.height, 9),
        cells(level.cells_x(), level.cells_y(), HF_CELL_PAIRS),
        usable(level.elements + kGuardFloats, 0) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(0, 1);
    std::normal_distribution<double> normal(0, 1);
    const auto f = [](double number) { return static_cast<double>(static_cast<float>(number)); };
    for (int y = 0; y < s.height; ++y) {
      for (int x = 0; x < s.width; ++x) {
        const bool flat = ((x / 7) + (y / 17)) % 4 == 0;
        for (int c = 0; c < 3; ++c) frame.at(x, y, c) = f(0.5 + (flat ? 0.003 : 0.085) * normal(random));
        frame.at(x, y, 3) = ((x / 9) + (y / 5)) % 23 == 0 ? 0.1 : 1.0;  // here and there nothing was recorded
      }
    }
    for (int y = 0; y < s.height; ++y) {
      for (int x = 0; x < s.width; ++x) {
        // Patches in which the view agrees and patches in which it does not, so that votes go both ways.
        const bool agrees = ((x / 13) + (y / 11)) % 3 != 0;
        const double noise = agrees ? 0.006 : 0.08;
        for (int c = 0; c < 3; ++c) {
          features.at(x, y, c) = frame.get(x, y, c);
          features.at(x, y, 3 + c) = (frame.get(x + 1, y, c) - frame.get(x - 1, y, c)) / 2;
          features.at(x, y, 6 + c) = (frame.get(x, y + 1, c) - frame.get(x, y - 1, c)) / 2;
          value.at(x, y, c) = f(frame.get(x, y, c) + 0.02 * normal(random));
          dx.at(x, y, c) = f((agrees ? features.get(x, y, 3 + c) : 0.0) + noise * normal(random));
          dy.at(x, y, c) = f((agrees ? features.get(x, y, 6 + c) : 0.0) + noise * normal(random));
        }
        depth.at(x, y, 0) = f(0.6 + 0.1 * uniform(random));
        const double draw = uniform(random);
        usable[static_cast<std::size_t>(level.layout.origin + y * level.layout.stride + x)] = draw < 0.05
                                                                                                  ? HF_NOT_VISIBLE
                                                                                              : draw < 0.1 ? HF_UNUSABLE
                                                                                                           : HF_USED;
      }
    }
    for (double& pair : cells.values) pair = f(uniform(random));
    for (int y = 0; y < cells.height; ++y) {
      for (int x = 0; x < cells.width; ++x) {
        for (int c = 0; c < 3; ++c) {
          cells.at(x, y, c) = f(0.9 + 0.2 * uniform(random));
          cells.at(x, y, 3 + c) = f(0.1 * uniform(random) - 0.05);
        }
      }
    }
    tiles = {0, 0, level.tiles_x(), level.tiles_y()};
    camera = {level.camera.fx, level.camera.fy, level.camera.cx, level.camera.cy};
  }

  std::uint8_t state(int x, int y) const {
    return usable[static_cast<std::size_t>(level.layout.origin + y * level.layout.stride + x)];
  }
};

struct DeviceScene {
  cl::Buffer value, dx, dy, depth, usable, frame, pairs, samples, classes, final_classes, sums;

  DeviceScene(const Device::Impl& impl, Scene& scene) {
    auto v = to_plane_memory(scene.value, scene.level), gx = to_plane_memory(scene.dx, scene.level),
         gy = to_plane_memory(scene.dy, scene.level), z = to_plane_memory(scene.depth, scene.level),
         f = to_memory(scene.frame, scene.level);
    std::vector<float> p(scene.cells.values.begin(), scene.cells.values.end());
    value = upload(impl, v);
    dx = upload(impl, gx);
    dy = upload(impl, gy);
    depth = upload(impl, z);
    usable = upload(impl, scene.usable);
    frame = upload(impl, f);
    pairs = upload(impl, p);
    samples = impl.zeroed_buffer((scene.level.elements + kGuardFloats) * HF_SAMPLES * sizeof(float));
    classes = impl.zeroed_buffer(scene.level.elements + kGuardFloats);
    final_classes = impl.zeroed_buffer(scene.level.elements + kGuardFloats);
    sums = impl.zeroed_buffer(static_cast<std::size_t>(scene.tiles.width * scene.tiles.height) * HF_SUM_STRIDE *
                              sizeof(float));
  }

  void run_tests(const Device::Impl& impl, const Scene& scene, const kernel::hf_warp& warp,
                 const kernel::hf_tests& tests) {
    cl::Kernel kernel = impl.kernel("occlusion_tests");
    kernel.setArg(0, value);
    kernel.setArg(1, dx);
    kernel.setArg(2, dy);
    kernel.setArg(3, static_cast<int>(scene.level.elements));
    kernel.setArg(4, depth);
    kernel.setArg(5, usable);
    kernel.setArg(6, scene.level.layout);
    kernel.setArg(7, scene.tiles);
    kernel.setArg(8, frame);
    kernel.setArg(9, warp);
    kernel.setArg(10, tests);
    kernel.setArg(11, pairs);
    kernel.setArg(12, scene.level.cells_x());
    kernel.setArg(13, samples);
    kernel.setArg(14, classes);
    impl.enqueue_tiles(kernel, scene.tiles.width, scene.tiles.height);
  }

  /// So that what is not written shows.
  void clear(const Device::Impl& impl, const Scene& scene) const {
    impl.queue.enqueueFillBuffer(classes, static_cast<cl_uchar>(15), 0, scene.level.elements);
    impl.queue.enqueueFillBuffer(samples, 0.0f, 0, scene.level.elements * HF_SAMPLES * sizeof(float));
  }

  std::vector<float> run_constraints(const Device::Impl& impl, const Scene& scene, const kernel::hf_constraints& k) {
    cl::Kernel kernel = impl.kernel("flow_constraints");
    kernel.setArg(0, value);
    kernel.setArg(1, dx);
    kernel.setArg(2, dy);
    kernel.setArg(3, static_cast<int>(scene.level.elements));
    kernel.setArg(4, depth);
    kernel.setArg(5, scene.level.layout);
    kernel.setArg(6, scene.tiles);
    kernel.setArg(7, samples);
    kernel.setArg(8, classes);
    kernel.setArg(9, k);
    kernel.setArg(10, pairs);
    kernel.setArg(11, scene.level.cells_x());
    kernel.setArg(12, final_classes);
    kernel.setArg(13, sums);
    impl.enqueue_tiles(kernel, scene.tiles.width, scene.tiles.height);
    return download<float>(impl, sums,
                           static_cast<std::size_t>(scene.tiles.width * scene.tiles.height) * HF_SUM_STRIDE);
  }
};

/// By a few pixels, or (`scale` small) by so little that random gradients still agree.
kernel::hf_warp small_warp(const Scene& scene, double scale) {
  Twist twist;
  twist << 0.002, -0.001, 0.003, 0.004, -0.006, 0.005;
  twist *= scale;
  const Rect valid{0, 0, scene.size.width, scene.size.height};
  return make_warp(scene.level.camera, exp_se3(twist), Eigen::Vector3d(0.01, 0.02, 0.65), valid);
}

/// Of rows that are not looked at.
constexpr int kUntouched = 15;

/// Class of a pixel, and whether a float could decide otherwise.
struct Verdict {
  int expected = 0;
  bool counts = false;
  bool close = false;
};

Verdict reference_class(const Scene& scene, const kernel::hf_warp& warp, const kernel::hf_tests& tests, int x, int y,
                        std::array<double, 9>& sample) {
  Verdict verdict;
  sample = {};
  const int state = scene.state(x, y);
  if (state != HF_USED) {
    verdict.expected = state;
    return verdict;
  }
  const double z = scene.depth.get(x, y, 0);
  const Eigen::Vector3d p((x - scene.camera.cx) / scene.camera.fx * z, (y - scene.camera.cy) / scene.camera.fy * z, z);
  Eigen::Matrix<double, 3, 4> D;
  for (int i = 0; i < 12; ++i) D(i / 4, i % 4) = static_cast<double>(warp.d[i]);
  const Eigen::Vector3d q = D * p.homogeneous();
  const double u = warp.still ? x : scene.camera.fx * q.x() / q.z() + scene.camera.cx;
  const double v = warp.still ? y : scene.camera.fy * q.y() / q.z() + scene.camera.cy;
  const double edge = std::min({u - static_cast<double>(warp.min_x), v - static_cast<double>(warp.min_y),
                                static_cast<double>(warp.max_x) - u, static_cast<double>(warp.max_y) - v});
  const double covered = reference::bilinear(scene.frame, u, v, 3) - static_cast<double>(HF_LEAST_COVERAGE);
  verdict.close = (!warp.still && std::abs(edge) < 1e-3) || std::abs(covered) < 1e-3;
  // Sampled from the least coordinates on, up to before the largest.
  if (edge < 0 || u >= static_cast<double>(warp.max_x) || v >= static_cast<double>(warp.max_y)) {
    verdict.expected = HF_UNUSABLE;
    return verdict;
  }
  if (covered < 0) {
    verdict.expected = HF_UNUSABLE;
    return verdict;
  }
  const auto raw = reference::sampled(scene.features, u, v);
  const auto near = [&](double a, double b, double scale) {
    if (std::abs(a - b) < 2e-3 * scale) verdict.close = true;
  };
  bool any = false, all = true, rendered_any = false, apart_angle = false, apart = false;
  std::vector<double> strong_v, strong_i;  // the strong channels' gradients, one after another
  for (int c = 0; c < 3; ++c) {
    const auto k = static_cast<std::size_t>(c);
    const double ix = static_cast<double>(warp.turn[0]) * raw[3 + k] + static_cast<double>(warp.turn[1]) * raw[6 + k];
    const double iy = static_cast<double>(warp.turn[2]) * raw[3 + k] + static_cast<double>(warp.turn[3]) * raw[6 + k];
    sample[k] = raw[k];
    sample[3 + k] = ix;
    sample[6 + k] = iy;
    const double gain = reference::cell_value(scene.cells, x, y, c);
    const Eigen::Vector2d gv(gain * scene.dx.get(x, y, c), gain * scene.dy.get(x, y, c)), gi(ix, iy);
    const double minimum = std::sqrt(static_cast<double>(tests.gradient_minimum2));
    near(gv.norm(), minimum, minimum);
    near(gi.norm(), minimum, minimum);
    const bool rendered = gv.norm() > minimum, strong = rendered && gi.norm() > minimum;
    any = any || strong;
    all = all && strong;
    rendered_any = rendered_any || rendered;
    const double cosine = std::sqrt(static_cast<double>(tests.angle_cosine2));
    if (strong && tests.angle_together) {
      strong_v.insert(strong_v.end(), {gv.x(), gv.y()});
      strong_i.insert(strong_i.end(), {gi.x(), gi.y()});
    } else if (strong) {
      near(gv.dot(gi), cosine * gv.norm() * gi.norm(), gv.norm() * gi.norm());
      near(gv.dot(gi), 0, gv.norm() * gi.norm());
      if (std::acos(std::clamp(gv.dot(gi) / (gv.norm() * gi.norm()), -1.0, 1.0)) > std::acos(cosine))
        apart_angle = true;
    }
    const double limit = static_cast<double>(tests.difference_maximum) +
                         static_cast<double>(tests.difference_relative) * std::max(gv.norm(), gi.norm());
    const double difference = tests.compare_magnitudes ? std::abs(gv.norm() - gi.norm()) : (gv - gi).norm();
    near(difference, limit, limit);
    apart = apart || difference >= limit;
  }
  if (!strong_v.empty()) {
    const auto count = static_cast<Eigen::Index>(strong_v.size());
    const Eigen::VectorXd all_v = Eigen::Map<Eigen::VectorXd>(strong_v.data(), count);
    const Eigen::VectorXd all_i = Eigen::Map<Eigen::VectorXd>(strong_i.data(), count);
    const double cosine = all_v.dot(all_i) / (all_v.norm() * all_i.norm());
    const double least = std::sqrt(static_cast<double>(tests.angle_cosine2));
    near(cosine, least, 1);
    near(cosine, 0, 1);
    apart_angle = cosine < least;
  }
  verdict.expected = HF_USED;
  if (tests.magnitude_test && apart) verdict.expected = HF_REJECTED_MAGNITUDE;
  if (tests.angle_test && apart_angle) verdict.expected = HF_REJECTED_ANGLE;
  if (tests.gradient_test && !(tests.all_channels ? all : any)) verdict.expected = HF_NO_GRADIENT;
  verdict.counts = rendered_any || (tests.magnitude_test && apart);
  return verdict;
}

void check_occlusion_tests(Size size) {
  for (const Partition partition : partitions()) {
    const Device device = make_device(partition);
    const Device::Impl& impl = device.impl();
    Scene scene(size, 21);
    DeviceScene on_device(impl, scene);
    kernel::hf_warp warp = small_warp(scene, size.width > 100 ? 0.01 : 1.0);
    for (int variant = 0; variant < 9; ++variant) {
      CAPTURE(variant);
      OcclusionOptions options;
      options.angle_together = variant != 8;
      if (variant == 1) options.all_channels = true;
      if (variant == 2) {
        options.compare_magnitudes = true;
        options.difference_relative = 0;
      }
      if (variant == 3) options.angle_test = false;
      if (variant == 4) options.gradient_test = options.magnitude_test = false;
      if (variant == 6) warp = small_warp(scene, 0);
      CHECK(warp.still == (variant >= 6));
      warp.every = variant == 5 ? 3 : 1;
      auto tests = make_tests(options);
      tests.keep_gradients = variant != 7;
      on_device.clear(impl, scene);
      on_device.run_tests(impl, scene, warp, tests);
      const auto classes = download<std::uint8_t>(impl, on_device.classes, scene.level.elements);
      const auto samples = download<float>(impl, on_device.samples, scene.level.elements * HF_SAMPLES);
      int wrong = 0, close = 0;
      double largest = 0;
      std::array<int, 16> seen{};
      for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) {
          std::array<double, 9> sample{};
          const Verdict verdict = y % warp.every == 0 ? reference_class(scene, warp, tests, x, y, sample)
                                                      : Verdict{kUntouched, false, false};
          const auto e = static_cast<std::size_t>(scene.level.layout.origin + y * scene.level.layout.stride + x);
          ++seen[static_cast<std::size_t>(classes[e] & 15)];
          if (verdict.expected == kUntouched) {
            if (classes[e] != kUntouched) ++wrong;
            continue;
          }
          if (verdict.close) {
            ++close;
            continue;
          }
          if ((classes[e] & 15) != verdict.expected || (classes[e] >> 4 != 0) != verdict.counts) ++wrong;
          if (verdict.expected < HF_NO_GRADIENT) continue;
          for (std::size_t c = 0; c < 9; ++c) {
            const double wanted = c < 3 || tests.keep_gradients ? sample[c] : 0;
            largest = std::max(largest, std::abs(static_cast<double>(samples[e + c * scene.level.elements]) - wanted));
          }
        }
      }
      CHECK(wrong == 0);
      CHECK(largest < 2e-4);
      CHECK(close <= 1 + size.width * size.height / 20);
      if (size.width > 100) {  // the scene exercises every outcome
        for (const int outcome : {HF_NOT_VISIBLE, HF_UNUSABLE, HF_USED})
          CHECK(seen[static_cast<std::size_t>(outcome)] > 0);
        if (variant == 0) {
          for (const int outcome : {HF_NO_GRADIENT, HF_REJECTED_ANGLE, HF_REJECTED_MAGNITUDE}) {
            CHECK(seen[static_cast<std::size_t>(outcome)] > 50);
          }
        }
      }
    }
  }
}

void check_flow_constraints(Size size) {
  for (const Partition partition : partitions()) {
    const Device device = make_device(partition);
    const Device::Impl& impl = device.impl();
    Scene scene(size, 33);
    DeviceScene on_device(impl, scene);
    on_device.run_tests(impl, scene, small_warp(scene, 0.01), make_tests(OcclusionOptions{}));
    const auto classes = download<std::uint8_t>(impl, on_device.classes, scene.level.elements);
    const auto samples = download<float>(impl, on_device.samples, scene.level.elements * HF_SAMPLES);
    for (int variant = 0; variant < 5; ++variant) {
      CAPTURE(variant);
      kernel::hf_constraints k{};
      k.center[0] = 0.01f;
      k.center[1] = -0.02f;
      k.center[2] = 0.65f;
      k.radius = 0.12f;
      k.fx = static_cast<float>(scene.camera.fx);
      k.fy = static_cast<float>(scene.camera.fy);
      k.cx = static_cast<float>(scene.camera.cx);
      k.cy = static_cast<float>(scene.camera.cy);
      k.block_vote = variant != 1;
      k.vote_radius = variant == 3 ? 2 : 4;
      k.vote_share = 0.6180f;  // no count times it is a whole number: no ties to round
      k.robust = variant != 1;
      k.inverse_scale2 = 1 / (0.03f * 0.03f);
      k.freedom = 4;
      k.mean_gradient = variant != 2;
      k.redundancy = variant == 2;
      k.redundancy_cosine2 = 0.81f;
      k.every = variant == 4 ? 3 : 1;
      k.elimination = variant != 3;
      const auto sums = on_device.run_constraints(impl, scene, k);
      const auto final_classes = download<std::uint8_t>(impl, on_device.final_classes, scene.level.elements);

      const auto class_at = [&](int x, int y) -> int {
        if (x < 0 || y < 0 || x >= size.width || y >= size.height) return 0;
        return classes[static_cast<std::size_t>(scene.level.layout.origin + y * scene.level.layout.stride + x)];
      };
      Matrix6 A = Matrix6::Zero(), A_size = Matrix6::Zero();
      Twist h = Twist::Zero(), h_size = Twist::Zero();
      double square = 0, weight_sum = 0, rows = 0, used = 0, outvoted = 0, visible = 0, gradient = 0, passed = 0;
      std::array<double, HF_CELL_SUMS> cells{}, cells_size{};
      int class_errors = 0;
      for (int y = 0; y < size.height; y += k.every) {
        for (int x = 0; x < size.width; ++x) {
          const int c0 = class_at(x, y);
          visible += (c0 & 15) != 0;
          gradient += c0 >> 4;
          passed += (c0 & 15) == HF_USED;
          int expected = c0 & 15;
          if (expected == HF_USED && k.block_vote) {
            double counted = 0, agreed = 0;
            for (int j = -k.vote_radius; j <= k.vote_radius; ++j) {
              if ((y + j) % k.every != 0) continue;
              for (int i = -k.vote_radius; i <= k.vote_radius; ++i) {
                const int other = class_at(x + i, y + j);
                counted += other >> 4;
                agreed += (other >> 4) && (other & 15) == HF_USED;
              }
            }
            if (agreed < static_cast<double>(k.vote_share) * counted) expected = HF_REJECTED_VOTE;
          }
          const auto e = static_cast<std::size_t>(scene.level.layout.origin + y * scene.level.layout.stride + x);
          if (final_classes[e] != expected) ++class_errors;
          outvoted += expected == HF_REJECTED_VOTE;
          if (expected != HF_USED) continue;
          ++used;
          const double z = scene.depth.get(x, y, 0);
          cells[HF_CELL_PIXELS] += 1;
          cells[HF_CELL_DEPTH] += z;
          std::array<Eigen::Vector2d, 3> gv, gi;
          std::array<double, 3> r{};
          std::size_t strongest = 0;
          for (std::size_t c = 0; c < 3; ++c) {
            const int channel = static_cast<int>(c);
            const double gain = reference::cell_value(scene.cells, x, y, channel);
            const double bias = reference::cell_value(scene.cells, x, y, 3 + channel);
            const auto sample = [&](std::size_t plane) {
              return static_cast<double>(samples[e + plane * scene.level.elements]);
            };
            gv[c] = gain * Eigen::Vector2d(scene.dx.get(x, y, channel), scene.dy.get(x, y, channel));
            gi[c] = {sample(3 + c), sample(6 + c)};
            r[c] = gain * scene.value.get(x, y, channel) + bias - sample(c);
            if (gv[c].norm() > gv[strongest].norm()) strongest = c;
          }
          bool second = false;
          for (std::size_t c = 0; c < 3; ++c) {
            const int channel = static_cast<int>(c);
            const Eigen::Vector2d g = k.mean_gradient ? Eigen::Vector2d(0.5 * (gv[c] + gi[c])) : gv[c];
            double weight = 1;
            if (k.robust) weight = 5.0 / (4.0 + r[c] * r[c] / (0.03 * 0.03));
            const double v = scene.value.get(x, y, channel);
            const double seen = static_cast<double>(samples[e + c * scene.level.elements]);
            const std::array<double, HF_PHOTO> moments{weight,         weight * v,           weight * seen,
                                                       weight * v * v, weight * seen * seen, weight * v * seen,
                                                       weight * r[c],  weight * v * r[c],    weight * g.x(),
                                                       weight * g.y(), weight * v * g.x(),   weight * v * g.y()};
            for (std::size_t i = 0; i < (k.elimination ? HF_PHOTO : 6); ++i) {
              cells[c * HF_PHOTO + i] += moments[i];
              cells_size[c * HF_PHOTO + i] += std::abs(moments[i]);
            }
            if (k.redundancy && c != strongest) {
              const bool repeats = std::abs(gv[c].dot(gv[strongest])) > 0.9 * gv[c].norm() * gv[strongest].norm();
              if (repeats || second) continue;
              second = true;
            }
            ++rows;
            weight_sum += weight;
            square += weight * r[c] * r[c];
            const Eigen::Vector3d center(static_cast<double>(k.center[0]), static_cast<double>(k.center[1]),
                                         static_cast<double>(k.center[2]));
            const Twist row =
                reference::flow_row(scene.camera, x, y, z, g.x(), g.y(), center, static_cast<double>(k.radius));
            A += weight * row * row.transpose();
            h += weight * row * r[c];
            A_size += weight * (row * row.transpose()).cwiseAbs();
            h_size += weight * (row * r[c]).cwiseAbs();
          }
        }
      }
      CHECK(class_errors == 0);
      std::array<double, HF_SUM_MAIN> got{};
      std::array<double, HF_CELL_SUMS> got_cells{};
      for (std::size_t t = 0; t < sums.size() / HF_SUM_STRIDE; ++t) {
        for (std::size_t i = 0; i < HF_SUM_MAIN; ++i) got[i] += static_cast<double>(sums[t * HF_SUM_STRIDE + i]);
        for (std::size_t i = 0; i < 4 * HF_CELL_SUMS; ++i) {
          got_cells[i % HF_CELL_SUMS] += static_cast<double>(sums[t * HF_SUM_STRIDE + HF_SUM_PHOTO + i]);
        }
      }
      // A row may be counted on one side only where a cosine is within rounding of the redundancy limit.
      const double row_tolerance = k.redundancy ? 2e-3 : 1e-5;
      CHECK(std::abs(got[HF_SUM_ROWS] - rows) <= (k.redundancy ? 3 : 0));
      CHECK(got[HF_SUM_USED] == used);
      CHECK(got[HF_SUM_VISIBLE] == visible);
      CHECK(got[HF_SUM_GRADIENT] == gradient);
      CHECK(got[HF_SUM_PASSED] == passed);
      CHECK(std::abs(got[HF_SUM_WRR] - square) <= row_tolerance * square + 1e-9);
      CHECK(std::abs(got[HF_SUM_W] - weight_sum) <= row_tolerance * weight_sum + 1e-9);
      std::size_t n = HF_SUM_A;
      double worst = 0;
      for (int i = 0; i < 6; ++i) {
        for (int j = i; j < 6; ++j) worst = std::max(worst, std::abs(got[n++] - A(i, j)) / (A_size(i, j) + 1e-9));
        worst = std::max(worst, std::abs(got[static_cast<std::size_t>(HF_SUM_H + i)] - h(i)) / (h_size(i) + 1e-9));
      }
      CHECK(worst < 2 * row_tolerance);
      double worst_cell = 0;
      cells_size[HF_CELL_PIXELS] = cells[HF_CELL_PIXELS];
      cells_size[HF_CELL_DEPTH] = cells[HF_CELL_DEPTH];
      for (std::size_t i = 0; i < HF_CELL_SUMS; ++i) {
        worst_cell = std::max(worst_cell, std::abs(got_cells[i] - cells[i]) / (cells_size[i] + 1e-9));
      }
      CHECK(worst_cell < 2e-5);
      if (size.width > 100) {
        CHECK(used > 1000);
        if (k.block_vote) CHECK(outvoted > 100);
      }
      // The same bits again.
      const auto again = on_device.run_constraints(impl, scene, k);
      CHECK(std::memcmp(sums.data(), again.data(), sums.size() * sizeof(float)) == 0);
    }
  }
}

void check_view_template(Size size) {
  for (const Partition partition : partitions()) {
    const Device device = make_device(partition);
    const Device::Impl& impl = device.impl();
    Camera camera{size.width, size.height, 100, 100, 0, 0, {}};
    const auto levels = make_levels(camera, 2);
    const Level& level = levels[0];
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(0, 1);
    const int stride = level.padded_width + 3;
    std::vector<std::uint8_t> rgba(static_cast<std::size_t>(stride * level.padded_height * 4), 0);
    std::vector<float> window(static_cast<std::size_t>(stride * level.padded_height), 1.0f);
    const double near_plane = 0.5, far_plane = 0.9;
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const auto i = static_cast<std::size_t>(y * stride + x);
        for (std::size_t c = 0; c < 3; ++c) rgba[4 * i + c] = static_cast<std::uint8_t>(random());
        rgba[4 * i + 3] = uniform(random) < 0.2 ? 0 : 255;
        if (uniform(random) < 0.8) window[i] = static_cast<float>(0.95 * uniform(random));
      }
    }
    for (const int grey : {0, 1}) {
      const cl::Buffer rgba_buffer = upload(impl, rgba), window_buffer = upload(impl, window);
      const cl::Buffer pixels = impl.zeroed_buffer((level.elements + kGuardFloats) * 4 * sizeof(float));
      const cl::Buffer depth = impl.zeroed_buffer((level.elements + kGuardFloats) * sizeof(float));
      kernel::hf_view view{stride, grey, static_cast<float>(near_plane), static_cast<float>(far_plane)};
      cl::Kernel unpack = impl.kernel("unpack_view");
      unpack.setArg(0, rgba_buffer);
      unpack.setArg(1, window_buffer);
      unpack.setArg(2, view);
      unpack.setArg(3, to_kernel(whole(level)));
      unpack.setArg(4, level.layout);
      unpack.setArg(5, pixels);
      unpack.setArg(6, depth);
      impl.enqueue_rows(unpack, level.padded_width, level.padded_height);
      Planes expected(size.width, size.height, 4), z(size.width, size.height, 1);
      for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) {
          const auto i = static_cast<std::size_t>(y * stride + x);
          const double d = static_cast<double>(window[i]);
          if (d >= 1) continue;
          z.at(x, y, 0) = near_plane * far_plane / (far_plane - d * (far_plane - near_plane));
          if (rgba[4 * i + 3] == 0) continue;
          for (int c = 0; c < 3; ++c) expected.at(x, y, c) = rgba[4 * i + static_cast<std::size_t>(c)] / 255.0;
          if (grey) {
            const double luma =
                0.299 * expected.get(x, y, 0) + 0.587 * expected.get(x, y, 1) + 0.114 * expected.get(x, y, 2);
            expected.at(x, y, 0) = luma;
            expected.at(x, y, 1) = expected.at(x, y, 2) = 0;
          }
          expected.at(x, y, 3) = 1;
        }
      }
      CHECK(largest_difference(download<float>(impl, pixels, level.elements * 4), level, expected) < 1e-6);
      CHECK(largest_difference(download<float>(impl, depth, level.elements), level, z) < 1e-6);

      const cl::Buffer half = impl.zeroed_buffer((levels[1].elements + kGuardFloats) * sizeof(float));
      cl::Kernel halve = impl.kernel("halve_depth");
      halve.setArg(0, depth);
      halve.setArg(1, level.layout);
      halve.setArg(2, to_kernel(whole(levels[1])));
      halve.setArg(3, levels[1].layout);
      halve.setArg(4, half);
      impl.enqueue_rows(halve, levels[1].padded_width, levels[1].padded_height);
      Planes half_expected(levels[1].width, levels[1].height, 1);
      for (int y = 0; y < half_expected.height; ++y) {
        for (int x = 0; x < half_expected.width; ++x) {
          double sum = 0, count = 0;
          for (int j = 0; j <= 1; ++j) {
            for (int i = 0; i <= 1; ++i) {
              const double one = z.get(2 * x + i, 2 * y + j, 0);
              sum += one;
              count += one > 0;
            }
          }
          half_expected.at(x, y, 0) = count > 0 ? sum / count : 0;
        }
      }
      CHECK(largest_difference(download<float>(impl, half, levels[1].elements), levels[1], half_expected) < 1e-6);
    }
  }
}

void check_template_planes(Size size, float bend) {
  for (const Partition partition : partitions()) {
    const Device device = make_device(partition);
    const Device::Impl& impl = device.impl();
    const Level level = make_level(size);
    const Planes in = random_pixels(size, 3);
    std::mt19937 random(4);
    std::uniform_real_distribution<double> uniform(0, 1);
    Planes depth(size.width, size.height, 1);
    for (double& z : depth.values) {
      // Levels of depth far from the jump's limit, and holes.
      z = uniform(random) < 0.1 ? 0.0 : uniform(random) < 0.1 ? 0.7f : uniform(random) < 0.1 ? 0.605f : 0.6f;
    }
    auto memory = to_memory(in, level);
    auto depth_memory = to_plane_memory(depth, level);
    const cl::Buffer in_buffer = upload(impl, memory), depth_buffer = upload(impl, depth_memory);
    const std::size_t plane_bytes = (level.elements * 3 + kGuardFloats) * sizeof(float);
    const cl::Buffer value = impl.zeroed_buffer(plane_bytes), dx = impl.zeroed_buffer(plane_bytes),
                     dy = impl.zeroed_buffer(plane_bytes), usable = impl.zeroed_buffer(level.elements + kGuardFloats);
    cl::Kernel kernel = impl.kernel("template_planes");
    const float least_coverage = 0.85f;
    kernel.setArg(0, in_buffer);
    kernel.setArg(1, depth_buffer);
    kernel.setArg(2, level.layout);
    kernel.setArg(3, to_kernel(whole(level)));
    const int reach = 2;
    kernel.setArg(4, level.width);
    kernel.setArg(5, level.height);
    kernel.setArg(6, least_coverage);
    kernel.setArg(7, 0.02f);
    kernel.setArg(8, reach);
    kernel.setArg(9, value);
    kernel.setArg(10, dx);
    kernel.setArg(11, dy);
    kernel.setArg(12, static_cast<int>(level.elements));
    kernel.setArg(13, usable);
    kernel.setArg(14, bend);
    impl.enqueue_rows(kernel, level.padded_width, level.padded_height);
    const auto got_value = download<float>(impl, value, level.elements * 3);
    const auto got_dx = download<float>(impl, dx, level.elements * 3);
    const auto got_dy = download<float>(impl, dy, level.elements * 3);
    const auto got_usable = download<std::uint8_t>(impl, usable, level.elements);
    double largest = 0;
    int wrong = 0;
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const auto e = static_cast<std::size_t>(level.layout.origin + y * level.layout.stride + x);
        const double z = depth.get(x, y, 0);
        int expected = HF_NOT_VISIBLE;
        if (z > 0) {
          bool good = in.get(x, y, 3) >= static_cast<double>(least_coverage);
          const int neighbours[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
          for (const auto& n : neighbours) {
            good = good && in.get(x + n[0], y + n[1], 3) > 0.25;
            for (int k = 1; k <= reach; ++k) {
              const double other = depth.get(x + k * n[0], y + k * n[1], 0);
              good = good && other > 0 && std::abs(other - z) <= 0.02 * z;
            }
            for (const int k : {1, 3}) {
              const double before = depth.get(x - k * n[0], y - k * n[1], 0);
              const double after = depth.get(x + k * n[0], y + k * n[1], 0);
              if (bend > 0 && before > 0 && after > 0 && std::abs(z / before + z / after - 2) > 0.004) good = false;
            }
          }
          expected = good ? HF_USED : HF_UNUSABLE;
        }
        if (got_usable[e] != expected) ++wrong;
        if (z <= 0) continue;  // nothing reads the planes there
        for (int c = 0; c < 3; ++c) {
          const auto i = e + static_cast<std::size_t>(c) * level.elements;
          const double wanted[3] = {z > 0 ? in.get(x, y, c) : 0,
                                    z > 0 ? (in.get(x + 1, y, c) - in.get(x - 1, y, c)) / 2 : 0,
                                    z > 0 ? (in.get(x, y + 1, c) - in.get(x, y - 1, c)) / 2 : 0};
          largest = std::max({largest, std::abs(static_cast<double>(got_value[i]) - wanted[0]),
                              std::abs(static_cast<double>(got_dx[i]) - wanted[1]),
                              std::abs(static_cast<double>(got_dy[i]) - wanted[2])});
        }
      }
    }
    CHECK(wrong == 0);
    CHECK(largest < 1e-6);
  }
}

void check_shift_scores(Size size) {
  for (const Partition partition : partitions()) {
    const Device device = make_device(partition);
    const Device::Impl& impl = device.impl();
    Scene scene(size, 55);
    DeviceScene on_device(impl, scene);
    // A step of 3 on large images: llvmpipe ends all loops of a kernel after 65535 passes.
    const Rect shifts = size.width > 100 ? Rect{-2, -1, 5, 3} : Rect{-9, -7, 21, 16};
    const int step = size.width > 100 ? 3 : 2;
    const auto count = static_cast<std::size_t>(shifts.width * shifts.height);
    const cl::Buffer scores = impl.zeroed_buffer(count * sizeof(float));
    const cl_int4 sampled{{1, 1, size.width - 2, size.height - 2}};
    const cl::Buffer gradients = impl.zeroed_buffer((scene.level.elements + kGuardFloats) * 7 * sizeof(float));
    cl::Kernel differentiate = impl.kernel("frame_gradients");
    differentiate.setArg(0, on_device.frame);
    differentiate.setArg(1, scene.level.layout);
    differentiate.setArg(2, to_kernel(whole(scene.level)));
    differentiate.setArg(3, gradients);
    differentiate.setArg(4, static_cast<int>(scene.level.elements));
    impl.enqueue_rows(differentiate, scene.level.padded_width, scene.level.padded_height);
    cl::Kernel kernel = impl.kernel("shift_scores");
    kernel.setArg(0, on_device.dx);
    kernel.setArg(1, on_device.dy);
    kernel.setArg(2, static_cast<int>(scene.level.elements));
    kernel.setArg(3, on_device.usable);
    kernel.setArg(4, scene.level.layout);
    kernel.setArg(5, to_kernel(whole(scene.level)));
    kernel.setArg(6, step);
    kernel.setArg(7, gradients);
    kernel.setArg(8, static_cast<int>(scene.level.elements));
    kernel.setArg(9, sampled);
    kernel.setArg(10, cl_int2{{shifts.x, shifts.y}});
    kernel.setArg(11, shifts.width);
    kernel.setArg(12, scores);
    impl.queue.enqueueNDRangeKernel(
        kernel, cl::NullRange,
        cl::NDRange(static_cast<std::size_t>(impl.strips ? (shifts.width + 15) / 16 : shifts.width),
                    static_cast<std::size_t>(shifts.height)),
        cl::NDRange(1, 1));
    const auto got = download<float>(impl, scores, count);
    for (int sy = shifts.y; sy < shifts.y + shifts.height; ++sy) {
      for (int sx = shifts.x; sx < shifts.x + shifts.width; ++sx) {
        double agreement = 0, weight = 0;
        for (int y = 0; y < size.height; y += step) {
          for (int x = 0; x < size.width; x += step) {
            if (scene.state(x, y) != HF_USED) continue;
            double vv = 0, ii = 0, vi = 0;
            const int u = x + sx, v = y + sy;
            for (int c = 0; c < 3; ++c) {
              const double vx = scene.dx.get(x, y, c), vy = scene.dy.get(x, y, c);
              const double ix = scene.features.get(u, v, 3 + c), iy = scene.features.get(u, v, 6 + c);
              vv += vx * vx + vy * vy;
              ii += ix * ix + iy * iy;
              vi += vx * ix + vy * iy;
            }
            if (vv < 1e-5) continue;
            weight += std::sqrt(vv);
            if (u < 1 || v < 1 || u > size.width - 2 || v > size.height - 2) continue;
            agreement += std::sqrt(vv) * vi / (0.5 * (vv + ii) + 1e-5);
          }
        }
        const double expected = weight > 0 ? agreement / weight : 0;
        CHECK(static_cast<double>(got[static_cast<std::size_t>((sy - shifts.y) * shifts.width + sx - shifts.x)]) ==
              doctest::Approx(expected).epsilon(1e-3).scale(0.1));
      }
    }
  }
}

}  // namespace

void check_template_planes_kept(Size size) { check_template_planes(size, 0.0f); }
void check_template_planes_bent(Size size) { check_template_planes(size, 0.004f); }

#define SMALL_AND_LARGE(NAME, CHECK_FUNCTION)            \
  TEST_CASE(NAME ": 1x1 and 17x13") {                    \
    for (const Size size : kSmall) {                     \
      CAPTURE(size.width);                               \
      CHECK_FUNCTION(size);                              \
    }                                                    \
  }                                                      \
  TEST_CASE(NAME ": 640x480") {                          \
    for (const Size size : kLarge) CHECK_FUNCTION(size); \
  }

SMALL_AND_LARGE("blur", check_blur)
SMALL_AND_LARGE("halving", check_halve)
SMALL_AND_LARGE("conversion of every frame format, plain and distorted", check_conversion)
SMALL_AND_LARGE("unpacking and halving the view", check_view_template)
SMALL_AND_LARGE("template planes and usability", check_template_planes_kept)
SMALL_AND_LARGE("template planes away from edges between faces", check_template_planes_bent)
SMALL_AND_LARGE("occlusion tests", check_occlusion_tests)
SMALL_AND_LARGE("vote, flow constraints and their sums", check_flow_constraints)
SMALL_AND_LARGE("shift scores", check_shift_scores)

TEST_CASE("the flow row is the derivative of intensity along all six axes") {
  // A smooth image on a surface; fx != fy, principal point off centre. Intensity at the projection of exp(xi) P, by
  // central differences, against the row.
  const reference::Camera camera{611, 587, 201.3, 131.7};
  const Eigen::Vector3d center(0.03, -0.02, 0.71);
  const double radius = 0.11;
  const auto image = [](double x, double y) {
    return 0.5 + 0.2 * std::sin(0.11 * x + 0.05 * y) + 0.1 * std::cos(0.07 * y - 0.02 * x);
  };
  const auto slope = [](double x, double y) {
    return Eigen::Vector2d(0.2 * 0.11 * std::cos(0.11 * x + 0.05 * y) + 0.1 * 0.02 * std::sin(0.07 * y - 0.02 * x),
                           0.2 * 0.05 * std::cos(0.11 * x + 0.05 * y) - 0.1 * 0.07 * std::sin(0.07 * y - 0.02 * x));
  };
  for (const auto& [x, y, z] :
       {std::array{37.0, 92.0, 0.66}, std::array{310.0, 40.0, 0.75}, std::array{201.3, 131.7, 0.7}}) {
    const Eigen::Vector3d p((x - camera.cx) / camera.fx * z, (y - camera.cy) / camera.fy * z, z);
    const Eigen::Vector2d g = slope(x, y);
    const Twist row = reference::flow_row(camera, x, y, z, g.x(), g.y(), center, radius);
    for (int axis = 0; axis < 6; ++axis) {
      const double step = 1e-5;
      const auto intensity = [&](double amount) {
        // A conditioned motion: translation in radii, rotation about the centre (by the rotation's own formula).
        Eigen::Vector3d moved = p;
        if (axis < 3) {
          moved += radius * amount * Eigen::Vector3d::Unit(axis);
        } else {
          moved = center + Eigen::AngleAxisd(amount, Eigen::Vector3d::Unit(axis - 3)) * (p - center);
        }
        return image(camera.fx * moved.x() / moved.z() + camera.cx, camera.fy * moved.y() / moved.z() + camera.cy);
      };
      const double numeric = (intensity(step) - intensity(-step)) / (2 * step);
      CHECK(row(axis) == doctest::Approx(numeric).epsilon(1e-6).scale(1e-3));
    }
  }
}
