// Lines across an object's outline: the points they start from, the colours on both sides and the edges they find.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>

#include "holdfast/pose.hpp"
#include "object_colors.hpp"
#include "outline_points.hpp"
#include "solver.hpp"
#include "support/kernel_checks.hpp"

namespace {

using namespace holdfast;
using namespace holdfast::test;
using reference::Planes;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr int kReach = 11;
constexpr std::size_t kBinsOfLine = 2 * kReach + 1;
/// Not a multiple of a group, so that some work-items have no line.
constexpr std::size_t kLines = 101;
constexpr float kUntouched = 7.0F;
/// Positions closer to where rounding or a comparison turns may go either way in float, pixels.
constexpr double kMargin = 1e-3;

double as_float(double value) { return static_cast<double>(static_cast<float>(value)); }

int bin_of(const Eigen::Vector3d& color) {
  int bin = 0;
  for (int c = 0; c < 3; ++c) bin = 16 * bin + static_cast<int>(std::clamp(std::floor(color(c) * 16), 0.0, 15.0));
  return bin;
}

/// A pixel of the frame that a line passes.
struct Passed {
  int k;
  double beyond;
  Eigen::Vector3d color;
};

/// A line in double, and whether float may see other pixels than these.
struct ReferenceLine {
  Eigen::Vector3d p;
  Eigen::Vector2d pixel, normal;
  std::vector<Passed> passed;
  bool ambiguous = false;
};

/// All that the kernels read, but the points.
struct Setting {
  Level level;
  Planes frame;
  kernel::hf_outline outline{};
  std::vector<float> share;

  Setting(Size size, Planes pixels) : level(level_of(size)), frame(std::move(pixels)), share(ObjectColors::kBins) {
    outline.fx = static_cast<float>(level.camera.fx);
    outline.fy = static_cast<float>(level.camera.fy);
    outline.cx = static_cast<float>(level.camera.cx);
    outline.cy = static_cast<float>(level.camera.cy);
    outline.reach = kReach;
    outline.region = {0, 0, size.width, size.height};
    outline.radius = 1;
    outline.softness2 = 0.36F;
    outline.trust = 0.43F;
    outline.step = 1;
    outline.variance = 1;
    outline.beside = 2;
    outline.around = 6;
    move(Pose::Identity());
  }

  void move(const Pose& D) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) outline.d[4 * row + column] = static_cast<float>(D(row, column));
    }
  }

  Pose D() const {
    Pose D = Pose::Identity();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) D(row, column) = static_cast<double>(outline.d[4 * row + column]);
    }
    return D;
  }

  Eigen::Vector2d project(const Eigen::Vector3d& p) const {
    return {static_cast<double>(outline.fx) * p.x() / p.z() + static_cast<double>(outline.cx),
            static_cast<double>(outline.fy) * p.y() / p.z() + static_cast<double>(outline.cy)};
  }

  Eigen::Vector3d backproject(const Eigen::Vector2d& at, double z) const {
    return {(at.x() - static_cast<double>(outline.cx)) / static_cast<double>(outline.fx) * z,
            (at.y() - static_cast<double>(outline.cy)) / static_cast<double>(outline.fy) * z, z};
  }

  bool in_region(double x, double y) const {
    const kernel::hf_rect& r = outline.region;
    return x >= r.x && y >= r.y && x < r.x + r.width && y < r.y + r.height;
  }

  ReferenceLine line(const OutlinePoint& point) const {
    ReferenceLine line;
    line.p = D() * point.p_camera.cast<double>();
    line.normal = (D().linear().topLeftCorner<2, 2>() * point.normal.cast<double>()).normalized();
    if (line.p.z() <= 0) return line;
    line.pixel = project(line.p);
    const double inside = static_cast<double>(point.inside), outside = static_cast<double>(point.outside);
    for (int k = -outline.reach; k <= outline.reach; ++k) {
      const Eigen::Vector2d exact = line.pixel + k * line.normal;
      const Eigen::Vector2d at = exact.array().round();
      const double beyond = (at - line.pixel).dot(line.normal);
      const double off_half = 0.5 - (at - exact).cwiseAbs().maxCoeff();
      line.ambiguous |= std::min({off_half, std::abs(beyond + inside), std::abs(beyond - outside)}) < kMargin;
      if (!in_region(at.x(), at.y()) || beyond < -inside || beyond > outside) continue;
      const int x = static_cast<int>(at.x()), y = static_cast<int>(at.y());
      if (frame.get(x, y, 3) <= static_cast<double>(0.99F)) continue;
      line.passed.push_back({k, beyond, {frame.get(x, y, 0), frame.get(x, y, 1), frame.get(x, y, 2)}});
    }
    return line;
  }
};

/// What a line tells, in double.
struct Told {
  double distance = 0, information = 0, agreement = 0, weight = 0;
  Vector6 row = Vector6::Zero();
};

struct Edge {
  double offset, doubt;
};

std::optional<Edge> edge_by_shares(const kernel::hf_outline& o, const std::vector<Passed>& passed) {
  std::array<Eigen::Vector3d, 2> mean;
  double spread = static_cast<double>(HF_OUTLINE_NOISE2);
  for (const bool beyond : {false, true}) {
    std::vector<Eigen::Vector3d> colors;
    for (const Passed& pixel : passed) {
      const int steps = beyond ? pixel.k : -pixel.k;
      if (steps >= o.beside && steps <= o.around) colors.push_back(pixel.color);
    }
    if (colors.size() < 2) return std::nullopt;
    const auto count = static_cast<double>(colors.size());
    const Eigen::Vector3d middle =
        std::accumulate(colors.begin(), colors.end(), Eigen::Vector3d(Eigen::Vector3d::Zero())) / count;
    for (const Eigen::Vector3d& color : colors) spread += (color - middle).squaredNorm() / count;
    mean[beyond ? 1 : 0] = middle;
  }
  const Eigen::Vector3d across = mean[0] - mean[1];
  const double contrast2 = std::max(across.squaredNorm(), 1e-6);
  Edge edge{0, spread / contrast2};
  for (const Passed& pixel : passed) {
    if (std::abs(pixel.k) > o.beside) continue;
    const double share = std::clamp(across.dot(pixel.color - mean[1]) / contrast2, -0.5, 1.5);
    const double ramp = std::clamp(pixel.beyond / static_cast<double>(HF_OUTLINE_HALF_EDGE), -1.0, 1.0);
    const double window = std::max(0.0, 1 - std::pow(pixel.beyond / (o.beside + 0.5), 2));
    edge.offset += window * (share - (1 - ramp) / 2);
  }
  return edge;
}

/// d(pixel along the normal) / d(conditioned twist), by the chain rule.
Vector6 reference_row(const Setting& setting, const OutlinePoint& point, const ReferenceLine& line) {
  const kernel::hf_outline& o = setting.outline;
  const Eigen::Vector3d center(static_cast<double>(o.center[0]), static_cast<double>(o.center[1]),
                               static_cast<double>(o.center[2]));
  const Eigen::Vector3d arm = point.p_camera.cast<double>() - center;
  Eigen::Matrix<double, 3, 6> moved;
  moved << static_cast<double>(o.radius) * Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero();
  for (int axis = 0; axis < 3; ++axis) moved.col(3 + axis) = Eigen::Vector3d::Unit(axis).cross(arm);
  const double fx = static_cast<double>(o.fx), fy = static_cast<double>(o.fy), z = line.p.z();
  Eigen::Matrix<double, 2, 3> seen;
  seen << fx / z, 0, -fx * line.p.x() / (z * z), 0, fy / z, -fy * line.p.y() / (z * z);
  return (line.normal.transpose() * seen * setting.D().linear() * moved).transpose();
}

double soft_sign(double x, const kernel::hf_outline& o) {
  return x / std::sqrt(x * x + static_cast<double>(o.softness2));
}

/// Nothing where too few pixels of the line are seen; `unsure` where that hangs by float.
std::optional<Told> reference_told(const Setting& setting, const OutlinePoint& point, bool& unsure) {
  const kernel::hf_outline& o = setting.outline;
  const ReferenceLine line = setting.line(point);
  unsure = line.ambiguous;
  const auto contrast = [&](const Passed& pixel) {
    return 2 * static_cast<double>(setting.share[static_cast<std::size_t>(bin_of(pixel.color))]) - 1;
  };
  double seen = 0;
  Told told;
  for (const Passed& pixel : line.passed) {
    seen += std::abs(soft_sign(pixel.beyond, o));
    told.agreement -= contrast(pixel) * soft_sign(pixel.beyond, o);
  }
  const double least = static_cast<double>(HF_OUTLINE_LEAST_PIXELS);
  unsure |= std::abs(seen - least) < kMargin;
  if (seen < least) return std::nullopt;
  told.agreement /= seen;

  double all = 0, first = 0, second = 0;
  for (int j = 0; j < 16; ++j) {
    const double place = (j - 7.5) * static_cast<double>(o.step);
    double log_likelihood = 0;
    for (const Passed& pixel : line.passed) {
      log_likelihood +=
          std::log(0.5 - static_cast<double>(o.trust) * contrast(pixel) * soft_sign(pixel.beyond - place, o));
    }
    const double likelihood = std::exp(log_likelihood);
    all += likelihood;
    first += likelihood * place;
    second += likelihood * place * place;
  }
  const double by_colors = first / all, own = static_cast<double>(o.variance);
  const double variance = second / all - by_colors * by_colors;
  double flat = 0;
  for (int j = 0; j < 16; ++j) flat += std::pow((j - 7.5) * static_cast<double>(o.step), 2) / 16;
  told.information = std::max(0.0, 1 / (variance + own) - 1 / (flat + own));
  told.distance = by_colors;
  told.weight = told.information;
  if (o.by_shares != 0) {
    const std::optional<Edge> edge = edge_by_shares(o, line.passed);
    told.distance = edge ? edge->offset : 0;
    const double agreed = 1 / (1 + by_colors * by_colors / static_cast<double>(HF_OUTLINE_AGREED2));
    told.weight *= edge ? agreed / (static_cast<double>(HF_OUTLINE_LEAST_DOUBT) + edge->doubt) : 0;
  }
  const double far2 = static_cast<double>(o.far2);
  if (far2 > 0) told.weight *= far2 / (far2 + told.distance * told.distance);
  told.row = reference_row(setting, point, line);
  return told;
}

/// Runs a kernel over the lines; work-items beyond them must write nothing.
template <typename T>
std::vector<T> run_lines(const Device::Impl& device, const Setting& setting, const std::vector<OutlinePoint>& points,
                         const char* name, std::size_t values, T untouched) {
  const std::size_t items = (points.size() + HF_GROUP - 1) / HF_GROUP * HF_GROUP;
  const cl::Buffer frame = upload(device, to_memory(setting.frame, setting.level)), lines = upload(device, points);
  const cl::Buffer share = upload(device, setting.share);
  const cl::Buffer out = upload(device, std::vector<T>(items * values, untouched));
  kernel::hf_outline outline = setting.outline;
  outline.count = static_cast<int>(points.size());
  cl::Kernel kernel = device.kernel(name);
  if (std::is_same_v<T, int>) {
    set_arguments(kernel, frame, setting.level.layout, lines, outline, out);
  } else {
    set_arguments(kernel, frame, setting.level.layout, lines, outline, share, out);
  }
  device.queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(items),
                                    cl::NDRange(device.strips ? 1 : HF_GROUP));
  std::vector<T> result = download<T>(device, out, items * values);
  const auto end = result.begin() + static_cast<std::ptrdiff_t>(points.size() * values);
  CHECK(std::all_of(end, result.end(), [&](T value) { return value == untouched; }));
  result.erase(end, result.end());
  return result;
}

std::vector<int> run_colors(const Device::Impl& device, const Setting& setting,
                            const std::vector<OutlinePoint>& points) {
  return run_lines<int>(device, setting, points, "outline_colors", kBinsOfLine, static_cast<int>(kUntouched));
}

std::vector<float> run_constraints(const Device::Impl& device, const Setting& setting,
                                   const std::vector<OutlinePoint>& points) {
  return run_lines<float>(device, setting, points, "outline_constraints", HF_OUTLINE_SUMS, kUntouched);
}

/// Bands of two colours under noise, some of it strong, a pixel here and there that was not recorded, and colours at
/// and beyond the ends of what bins hold.
Planes banded_frame(Size size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> normal(0, 1);
  Planes frame(size.width, size.height, HF_PIXEL);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const bool band = (x + 2 * y) % 22 < 11;
      const double noise = y % 5 == 0 ? 0.25 : 0.05;
      for (int c = 0; c < 3; ++c) frame.at(x, y, c) = as_float((band == (c == 1) ? 0.3 : 0.7) + noise * normal(random));
      if (uniform(random) < 0.02) frame.at(x, y, 1) = 1;
      const double draw = uniform(random);
      frame.at(x, y, 3) = draw < 0.04 ? 0 : draw < 0.06 ? 0.5 : draw < 0.08 ? as_float(0.98) : draw < 0.1 ? 0.995F : 1;
    }
  }
  return frame;
}

/// A camera that has moved, a region smaller than the frame, colours that tell anything from all to nothing.
Setting random_setting(Size size, unsigned seed) {
  Setting setting(size, banded_frame(size, seed));
  std::mt19937 random(seed + 1);
  std::uniform_real_distribution<double> uniform(0, 1);
  Twist twist;
  twist << 0.03, -0.02, 0.04, 0.08, -0.06, 0.1;
  setting.move(exp_se3(twist));
  // Much as the bands are, so that lines find edges.
  for (std::size_t bin = 0; bin < setting.share.size(); ++bin) {
    const bool more_red = (bin >> 8) > (bin >> 4 & 15);
    setting.share[bin] = static_cast<float>(uniform(random) < 0.2 ? uniform(random) : more_red ? 0.9 : 0.2);
  }
  setting.outline.center[0] = 0.02F;
  setting.outline.center[1] = -0.03F;
  setting.outline.center[2] = 0.55F;
  setting.outline.radius = 0.13F;
  if (size.width > 8) setting.outline.region = {1, 2, size.width - 3, size.height - 3};
  return setting;
}

/// Lines that land around and beyond the region when D has moved them, none of which float may see otherwise.
std::vector<OutlinePoint> random_points(const Setting& setting, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  const Pose D_inverse = setting.D().inverse(Eigen::Affine);
  const double width = setting.frame.width, height = setting.frame.height;
  std::vector<OutlinePoint> points;
  while (points.size() < kLines) {
    const auto kind = points.size() % 10;
    const double around = kind == 0 ? 40 : kind < 4 ? 6 : 0;
    const Eigen::Vector2d at((width + 2 * around) * uniform(random) - around - 0.5,
                             (height + 2 * around) * uniform(random) - around - 0.5);
    const double angle = 2 * std::numbers::pi * uniform(random);
    OutlinePoint point;
    point.p_camera = (D_inverse * setting.backproject(at, 0.4 + 0.4 * uniform(random))).cast<float>();
    if (points.size() == 5) point.p_camera.z() -= 2;
    point.normal = Eigen::Vector2d(std::cos(angle), std::sin(angle)).cast<float>();
    point.inside = kind < 6 ? kReach : static_cast<float>(std::floor(12 * uniform(random)));
    point.outside = kind < 5 ? kReach : static_cast<float>(std::floor(12 * uniform(random)));
    point.unused = 99;
    bool unsure = false;
    reference_told(setting, point, unsure);
    if (!unsure) points.push_back(point);
  }
  return points;
}

/// By all that a line gives at most, so that the tolerances are relative to it.
void check_told(const float* line, const Told& told, double tolerance) {
  const auto value = [&](int i) { return static_cast<double>(line[i]); };
  CHECK(std::abs(value(HF_OUTLINE_DISTANCE) - told.distance) < tolerance);
  CHECK(std::abs(value(HF_OUTLINE_INFORMATION) - told.information) < tolerance);
  CHECK(std::abs(value(HF_OUTLINE_AGREEMENT) - told.agreement) < tolerance);
  const double most_weight = std::max(1.0, told.weight), most_distance = std::max(1.0, std::abs(told.distance));
  CHECK(std::abs(value(HF_OUTLINE_W) - told.weight) < tolerance * most_weight);
  CHECK(std::abs(value(HF_OUTLINE_WRR) - told.weight * told.distance * told.distance) <
        2 * tolerance * most_weight * most_distance * most_distance);
  const double most = told.row.cwiseAbs().maxCoeff();
  int n = HF_SUM_A;
  double off_A = 0, off_h = 0, off_outward = 0;
  for (int a = 0; a < 6; ++a) {
    for (int b = a; b < 6; ++b) off_A = std::max(off_A, std::abs(value(n++) - told.weight * told.row(a) * told.row(b)));
    off_h = std::max(off_h, std::abs(value(HF_SUM_H + a) - told.weight * told.row(a) * told.distance));
    off_outward = std::max(off_outward, std::abs(value(HF_OUTLINE_OUTWARD + a) - told.weight * told.row(a)));
  }
  CHECK(n == HF_SUM_H);
  CHECK(off_A < 2 * tolerance * most_weight * most * most);
  CHECK(off_h < 2 * tolerance * most_weight * most * most_distance);
  CHECK(off_outward < 2 * tolerance * most_weight * most);
  for (int i = HF_OUTLINE_OUTWARD + 6; i < HF_OUTLINE_SUMS; ++i) CHECK(line[i] == 0.0F);
}

void check_constraints(const Device::Impl& device, Size size) {
  Setting setting = random_setting(size, 3);
  std::vector<OutlinePoint> points = random_points(setting, 4);
  points[5].p_camera = (setting.D().inverse(Eigen::Affine) * Eigen::Vector3d(0, 0, -0.5)).cast<float>();
  // A pixel's place on a large frame has fewer bits left behind the point.
  const double tolerance = 1e-5 + 4e-7 * std::max(size.width, size.height);
  for (int variant = 0; variant < 8; ++variant) {
    CAPTURE(variant);
    setting.outline.by_shares = variant & 1;
    setting.outline.far2 = variant & 2 ? 1.7F : 0.0F;
    setting.outline.step = variant & 4 ? 0.5F : 1.0F;
    setting.outline.variance = variant & 4 ? 0.25F : 1.0F;
    setting.outline.beside = variant & 2 ? 1 : 2;
    setting.outline.around = variant & 2 ? 4 : 6;
    const std::vector<float> sums = run_constraints(device, setting, points);
    std::size_t telling = 0, silent = 0, weighing = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      CAPTURE(i);
      const float* line = sums.data() + i * HF_OUTLINE_SUMS;
      bool unsure = false;
      const std::optional<Told> told = reference_told(setting, points[i], unsure);
      REQUIRE(!unsure);
      if (told) {
        check_told(line, *told, tolerance);
      } else {
        CHECK(std::all_of(line, line + HF_OUTLINE_SUMS, [](float value) { return value == 0.0F; }));
      }
      ++(told ? telling : silent);
      weighing += told && told->weight > 0.01 ? 1 : 0;
    }
    CHECK(silent >= 3);
    if (size.width > 1) CHECK(telling >= 15);
    if (size.width > 1) CHECK(weighing >= 5);
    CHECK(run_constraints(device, setting, points) == sums);
  }
}

void check_colors(const Device::Impl& device, Size size) {
  const Setting setting = random_setting(size, 5);
  std::vector<OutlinePoint> points = random_points(setting, 6);
  std::vector<int> expected(points.size() * kBinsOfLine, -1);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (const Passed& pixel : setting.line(points[i]).passed) {
      expected[i * kBinsOfLine + static_cast<std::size_t>(kReach + pixel.k)] = bin_of(pixel.color);
    }
  }
  const std::vector<int> bins = run_colors(device, setting, points);
  CHECK(bins == expected);
  CHECK(run_colors(device, setting, points) == bins);
  const auto seen = bins.size() - static_cast<std::size_t>(std::count(bins.begin(), bins.end(), -1));
  if (size.width > 1) CHECK(seen > bins.size() / 10);
}

/// The row of a line is what its pixel's way along the normal changes by, the normal held fixed.
void check_row(const Device::Impl& device, Size size) {
  Setting setting = random_setting(size, 7);
  const std::vector<OutlinePoint> points = random_points(setting, 8);
  Conditioning conditioning;
  for (int axis = 0; axis < 3; ++axis) {
    conditioning.p_camera_center(axis) = static_cast<double>(setting.outline.center[axis]);
  }
  conditioning.radius = static_cast<double>(setting.outline.radius);
  const std::vector<float> sums = run_constraints(device, setting, points);
  int checked = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    CAPTURE(i);
    const float* line = sums.data() + i * HF_OUTLINE_SUMS;
    const double weight = static_cast<double>(line[HF_OUTLINE_W]),
                 distance = static_cast<double>(line[HF_OUTLINE_DISTANCE]);
    if (weight < 1e-3 || std::abs(distance) < 0.1) continue;
    ++checked;
    const Eigen::Vector2d normal = setting.line(points[i]).normal;
    const auto along = [&](const Vector6& y) {
      const Pose moved = setting.D() * exp_se3(conditioning.twist(y));
      return normal.dot(setting.project(moved * points[i].p_camera.cast<double>()));
    };
    Vector6 slope, row;
    constexpr double kStep = 1e-5;
    for (int a = 0; a < 6; ++a) {
      slope(a) = (along(kStep * Vector6::Unit(a)) - along(-kStep * Vector6::Unit(a))) / (2 * kStep);
      row(a) = static_cast<double>(line[HF_SUM_H + a]) / (weight * distance);
    }
    CHECK((row - slope).norm() < 1e-5 * slope.norm());
    int n = HF_SUM_A;
    double off = 0;
    for (int a = 0; a < 6; ++a) {
      for (int b = a; b < 6; ++b)
        off = std::max(off, std::abs(static_cast<double>(line[n++]) / weight - slope(a) * slope(b)));
    }
    CHECK(off < 1e-5 * slope.squaredNorm());
  }
  if (size.width > 1) CHECK(checked >= 8);
}

/// What it is for, in words: an outline drawn beside the edge of two colours is told how far and which way it is off.
void check_found_edge(const Device::Impl& device, Size size) {
  if (size.width < 13) return;
  const Eigen::Vector2d normal(std::cos(0.4), std::sin(0.4)), middle(0.5 * size.width, 0.5 * size.height);
  const Eigen::Vector3d inside(0.8, 0.3, 0.2), outside(0.2, 0.5, 0.7);
  Planes frame(size.width, size.height, HF_PIXEL);
  constexpr int kFine = 8;
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      int hits = 0;
      for (int n = 0; n < kFine * kFine; ++n) {
        const Eigen::Vector2d at(x + (n % kFine + 0.5) / kFine - 0.5, y + (n / kFine + 0.5) / kFine - 0.5);
        hits += normal.dot(at - middle) < 0 ? 1 : 0;
      }
      const double share = static_cast<double>(hits) / (kFine * kFine);
      for (int c = 0; c < 3; ++c) frame.at(x, y, c) = as_float(share * inside(c) + (1 - share) * outside(c));
      frame.at(x, y, 3) = 1;
    }
  }
  Setting setting(size, frame);
  setting.outline.variance = 0.25F;
  setting.outline.step = 0.5F;
  for (const bool swapped : {false, true}) {
    setting.share.assign(ObjectColors::kBins, 0.5F);
    setting.share[static_cast<std::size_t>(bin_of(inside))] = swapped ? 0.02F : 0.98F;
    setting.share[static_cast<std::size_t>(bin_of(outside))] = swapped ? 0.98F : 0.02F;
    for (const bool by_shares : {false, true}) {
      setting.outline.by_shares = by_shares ? 1 : 0;
      for (const double offset : {-1.0, -0.4, 0.0, 0.3, 0.8}) {
        CAPTURE(offset);
        std::vector<OutlinePoint> points;
        for (int i = 0; i < 9; ++i) {
          OutlinePoint point;
          const Eigen::Vector2d at =
              middle + (0.4 * i - 1.6) * Eigen::Vector2d(-normal.y(), normal.x()) - offset * normal;
          point.p_camera = setting.backproject(at, 0.6).cast<float>();
          point.normal = normal.cast<float>();
          point.inside = point.outside = 5;
          points.push_back(point);
        }
        const std::vector<float> sums = run_constraints(device, setting, points);
        double distance = 0, information = 0, agreement = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
          const float* line = sums.data() + i * HF_OUTLINE_SUMS;
          distance += static_cast<double>(line[HF_OUTLINE_DISTANCE]) / static_cast<double>(points.size());
          information += static_cast<double>(line[HF_OUTLINE_INFORMATION]) / static_cast<double>(points.size());
          agreement += static_cast<double>(line[HF_OUTLINE_AGREEMENT]) / static_cast<double>(points.size());
        }
        CHECK((swapped ? -agreement : agreement) > 0.8);
        if (by_shares) CHECK(std::abs(distance - offset) < (std::abs(offset) < 0.5 ? 0.04 : 0.12));
        if (swapped) continue;
        CHECK(information > 0.6);
        if (!by_shares) CHECK(std::abs(distance - offset) < 0.2);
      }
    }
  }
}

/// A picture of shapes, drawn as by a renderer: an object where a pixel's centre is in it, window depth.
class Drawing {
 public:
  Drawing(const Rect& rect, const std::function<bool(double, double)>& object) : rect_(rect) {
    for (int y = rect.y; y < rect.y + rect.height; ++y) {
      for (int x = rect.x; x < rect.x + rect.width; ++x) {
        const double window = kFar / (kFar - kNear) * (1 - kNear / z(x, y));
        depth_.push_back(object(x, y) ? static_cast<float>(window) : 1.0F);
      }
    }
  }

  /// Of the slanted plane on which the shapes lie, metres.
  static double z(double x, double y) { return 0.6 + 4e-4 * (x - 100) - 3e-4 * (y - 80); }

  std::vector<OutlinePoint> points(std::size_t most = 10000, int reach = kReach) const {
    std::vector<OutlinePoint> points(3);
    outline_points({depth_.data(), rect_, {kNear, kFar}}, camera(), most, reach, points);
    return points;
  }

  static Camera camera() { return {200, 160, 230, 210, 96, 83, {}}; }

  static Eigen::Vector2d pixel(const OutlinePoint& point) { return camera().project(point.p_camera.cast<double>()); }

 private:
  static constexpr double kNear = 0.4, kFar = 0.9;
  Rect rect_;
  std::vector<float> depth_;
};

double degrees_between(const OutlinePoint& point, const Eigen::Vector2d& normal) {
  return std::acos(std::clamp(point.normal.cast<double>().dot(normal), -1.0, 1.0)) * 180 / std::numbers::pi;
}

const Rect kDrawn{20, 12, 160, 140};

/// Bins of two lines of 2 x 3 + 1 pixels: as seen inside, as seen outside, and other ones between them.
std::vector<int> bins_of(std::array<int, 4> inside, std::array<int, 4> outside) {
  constexpr int kBetween = 4095;
  return {inside[0], inside[1], kBetween, kBetween, kBetween, outside[0], outside[1],
          inside[2], inside[3], kBetween, kBetween, kBetween, outside[2], outside[3]};
}

}  // namespace

SMALL_AND_LARGE("constraints of lines across the outline", check_constraints)
SMALL_AND_LARGE("colours of lines across the outline", check_colors)
SMALL_AND_LARGE("a line's row is the slope of its pixel", check_row)
SMALL_AND_LARGE("a line finds the edge of two colours", check_found_edge)

TEST_CASE("outline points of a disc") {
  const Eigen::Vector2d center(101.3, 78.8);
  constexpr double kRadius = 40.4;
  const Drawing drawing(kDrawn, [&](double x, double y) { return (Eigen::Vector2d(x, y) - center).norm() < kRadius; });
  const std::vector<OutlinePoint> points = drawing.points();
  CHECK(points.size() > 200);
  double sum = 0, squares = 0, worst = 0, worst_angle = 0, worst_depth = 0;
  for (const OutlinePoint& point : points) {
    const Eigen::Vector2d at = Drawing::pixel(point), out = at - center;
    const double off = out.norm() - kRadius;
    sum += off;
    squares += off * off;
    worst = std::max(worst, std::abs(off));
    worst_angle = std::max(worst_angle, degrees_between(point, out.normalized()));
    worst_depth = std::max(worst_depth, std::abs(static_cast<double>(point.p_camera.z()) - Drawing::z(at.x(), at.y())));
    CHECK(static_cast<double>(point.normal.norm()) == doctest::Approx(1));
    CHECK(point.inside == kReach);
    CHECK(point.outside == kReach);
  }
  const auto count = static_cast<double>(points.size());
  // Where it runs along rows or columns, its steps are longer than what is looked at around a pixel.
  CHECK(std::abs(sum / count) < 0.02);
  CHECK(std::sqrt(squares / count) < 0.14);
  CHECK(worst < 0.45);
  CHECK(worst_angle < 17);
  // The depth is that of the object's pixel, less than 1.5 pixels away.
  CHECK(worst_depth < 1.5 * std::hypot(4e-4, 3e-4));
}

TEST_CASE("outline points are at most as many as asked for") {
  const Drawing disc(kDrawn, [](double x, double y) { return std::hypot(x - 101.3, y - 78.8) < 40.4; });
  const std::size_t all = disc.points().size();
  for (const std::size_t most : {1, 2, 7, 50, 64, 100, 120, 224}) {
    CAPTURE(most);
    const std::size_t count = disc.points(most).size();
    CHECK(count <= most);
    CHECK(3 * count >= std::min(most, all));
  }
}

TEST_CASE("outline points are spread evenly along the outline") {
  const Drawing disc(kDrawn, [](double x, double y) { return std::hypot(x - 101.3, y - 78.8) < 40.4; });
  const Drawing bar(kDrawn, [](double x, double y) { return std::abs(x - 100) < 8 && std::abs(y - 80) < 60; });
  for (const std::size_t most : {50, 64, 100, 120, 160, 224}) {
    CAPTURE(most);
    std::array<double, 8> octants{};
    const std::vector<OutlinePoint> points = disc.points(most);
    for (const OutlinePoint& point : points) {
      const Eigen::Vector2d at = Drawing::pixel(point);
      const double turn = std::atan2(at.y() - 78.8, at.x() - 101.3) / (2 * std::numbers::pi) + 0.5;
      octants[std::min<std::size_t>(7, static_cast<std::size_t>(8 * turn))] += 1.0 / static_cast<double>(points.size());
    }
    CHECK(*std::min_element(octants.begin(), octants.end()) > 0.07);
    CHECK(*std::max_element(octants.begin(), octants.end()) < 0.18);
    double left = 0, right = 0;
    for (const OutlinePoint& point : bar.points(most)) {
      left += point.normal.x() < -0.9F ? 1 : 0;
      right += point.normal.x() > 0.9F ? 1 : 0;
    }
    CHECK(left >= 0.5 * right);
    CHECK(right >= 0.5 * left);
  }
}

TEST_CASE("outline points of a slanted edge") {
  const Eigen::Vector2d middle(100.37, 80.21);
  for (const double degrees : {7.0, 20.0, 33.0, 61.0, 104.0, 200.0, 305.0}) {
    CAPTURE(degrees);
    const double angle = degrees * std::numbers::pi / 180;
    const Eigen::Vector2d normal(std::cos(angle), std::sin(angle));
    const Drawing drawing(kDrawn, [&](double x, double y) { return normal.dot(Eigen::Vector2d(x, y) - middle) < 0; });
    const std::vector<OutlinePoint> points = drawing.points();
    CHECK(points.size() > 80);
    double sum = 0, squares = 0, worst_angle = 0;
    for (const OutlinePoint& point : points) {
      const Eigen::Vector2d at = Drawing::pixel(point);
      const double off = normal.dot(at - middle);
      sum += off;
      squares += off * off;
      worst_angle = std::max(worst_angle, degrees_between(point, normal));
      // The object also ends where the drawing does: that is none of its outline.
      CHECK(std::min({at.x() - kDrawn.x, at.y() - kDrawn.y, kDrawn.x + kDrawn.width - 1 - at.x(),
                      kDrawn.y + kDrawn.height - 1 - at.y()}) > 2);
    }
    const auto count = static_cast<double>(points.size());
    // Steps of an edge nearly along the columns are longer than what is looked at around a pixel.
    const bool long_steps = degrees < 10;
    CHECK(std::abs(sum / count) < 0.02);
    CHECK(std::sqrt(squares / count) < (long_steps ? 0.18 : 0.1));
    CHECK(worst_angle < (long_steps ? 13 : 8));
  }
}

TEST_CASE("outline points know how far the object and the background reach") {
  const auto box = [](double x, double y, const Rect& r) {
    return x >= r.x && y >= r.y && x < r.x + r.width && y < r.y + r.height;
  };
  // Of the middle of an upright side, where no corner is near.
  const auto check_side = [](const std::vector<OutlinePoint>& points, double x, double normal_x, float inside,
                             float outside) {
    CAPTURE(x);
    int count = 0;
    for (const OutlinePoint& point : points) {
      const Eigen::Vector2d at = Drawing::pixel(point);
      if (std::abs(at.x() - x) > 0.4 || std::abs(at.y() - 80) > 10) continue;
      ++count;
      CHECK(degrees_between(point, {normal_x, 0}) < 3);
      // Exactly between two pixels: the last one counts or not.
      CHECK(std::abs(point.inside - (inside - 0.5F)) <= 0.5F);
      CHECK(std::abs(point.outside - (outside - 0.5F)) <= 0.5F);
    }
    CHECK(count >= 15);
  };
  for (const int width : {3, 4, 5, 8}) {
    CAPTURE(width);
    const auto points = Drawing(kDrawn, [&](double x, double y) { return box(x, y, {100, 50, width, 60}); }).points();
    check_side(points, 99.5, -1, static_cast<float>(width), kReach);
    check_side(points, 99.5 + width, 1, static_cast<float>(width), kReach);
  }
  const auto thread = Drawing(kDrawn, [&](double x, double y) { return box(x, y, {100, 50, 1, 60}); }).points();
  for (const OutlinePoint& point : thread) CHECK(std::abs(Drawing::pixel(point).y() - 79.5) > 27);

  // From the left: 7 of the object, a hole of 6, more object than is looked at.
  const auto holed = Drawing(kDrawn, [&](double x, double y) {
                       return box(x, y, {70, 40, 50, 80}) && !box(x, y, {77, 60, 6, 40});
                     }).points();
  check_side(holed, 69.5, -1, 7, kReach);
  check_side(holed, 76.5, 1, 7, 6);
  check_side(holed, 82.5, -1, kReach, 6);
  check_side(holed, 119.5, 1, kReach, kReach);
  // More of the object behind a gap draws the outline of a thread beside it away from where the thread is seen.
  const auto fringed = Drawing(kDrawn, [&](double x, double y) {
                         return box(x, y, {100, 40, 1, 80}) || box(x, y, {103, 40, 50, 80});
                       }).points();
  CHECK(!fringed.empty());
  for (const OutlinePoint& point : fringed) CHECK(point.inside >= 2);
  // What is not drawn is neither.
  const auto at_border = Drawing(kDrawn, [&](double x, double y) {
                           return box(x, y, {130, 40, 43, 80}) || box(x, y, {20, 40, 7, 80});
                         }).points();
  check_side(at_border, 172.5, 1, kReach, 7);
  check_side(at_border, 26.5, 1, 7, kReach);

  for (const OutlinePoint& point : Drawing(kDrawn, [&](double x, double y) {
                                     return box(x, y, {70, 40, 50, 80});
                                   }).points(10000, 4)) {
    CHECK(point.inside <= 4);
    CHECK(point.outside <= 4);
  }
}

TEST_CASE("outline points where nothing, everything or a part of the picture is drawn") {
  CHECK(Drawing(kDrawn, [](double, double) { return false; }).points().empty());
  CHECK(Drawing(kDrawn, [](double, double) { return true; }).points().empty());
  CHECK(Drawing({40, 40, 5, 5}, [](double x, double y) { return x < 42 && y < 42; }).points().empty());
  CHECK(Drawing({40, 40, 0, 0}, [](double, double) { return true; }).points().empty());
  const Camera camera = Drawing::camera();
  const auto points =
      Drawing({120, 90, 120, 100}, [&](double x, double y) { return std::hypot(x - 190, y - 140) < 30; }).points();
  CHECK(points.size() > 60);
  for (const OutlinePoint& point : points) {
    const Eigen::Vector2d at = Drawing::pixel(point);
    CHECK(at.x() < camera.width);
    CHECK(at.y() < camera.height);
  }
}

TEST_CASE("colours are the object's as often as they are seen on its side") {
  ObjectColors colors;
  const auto share = [&](int bin) { return static_cast<double>(colors.share()[static_cast<std::size_t>(bin)]); };
  const auto all_even = [&] {
    return std::all_of(colors.share().begin(), colors.share().end(), [](float value) { return value == 0.5F; });
  };
  CHECK(colors.share().size() == 4096);
  CHECK(all_even());
  CHECK(!colors.known());
  colors.learn(bins_of({7, 7, 7, 8}, {9, 9, 9, 8}), 3);
  CHECK(colors.known());
  CHECK(share(7) > 0.9999);
  CHECK(share(9) < 1e-4);
  CHECK(share(8) == doctest::Approx(0.5));
  CHECK(share(1) == doctest::Approx(0.5));
  CHECK(share(4095) == doctest::Approx(0.5));

  // Known, a new frame moves frequencies a fifth of the way.
  colors.learn(bins_of({9, 9, 9, 9}, {9, 9, 9, 9}), 3);
  const double object_9 = 0.2 * 1, background_9 = 0.8 * 0.75 + 0.2 * 1;
  CHECK(share(9) == doctest::Approx(object_9 / (object_9 + background_9)).epsilon(1e-3));
  CHECK(share(7) > 0.9999);
  colors.learn(bins_of({9, 9, 9, 7}, {7, 7, 8, 8}), 3);
  const double object_7 = 0.8 * 0.8 * 0.75 + 0.2 * 0.25, background_7 = 0.2 * 0.5;
  CHECK(share(7) == doctest::Approx(object_7 / (object_7 + background_7)).epsilon(1e-3));

  colors.clear();
  CHECK(all_even());
  CHECK(!colors.known());
  // At full weight, as nothing is known any more.
  colors.learn(bins_of({5, 5, 5, 6}, {5, 6, 6, 6}), 3);
  CHECK(share(5) == doctest::Approx(0.75).epsilon(1e-3));
  CHECK(share(6) == doctest::Approx(0.25).epsilon(1e-3));
  CHECK(share(9) == doctest::Approx(0.5));
  colors.clear();
  colors.learn(bins_of({-1, -1, -1, -1}, {9, 9, 9, 9}), 3);
  CHECK(share(5) == doctest::Approx(0.5));
}

TEST_CASE("pixels that are none teach no colour") {
  ObjectColors colors;
  const auto share = [](const ObjectColors& of, int bin) {
    return static_cast<double>(of.share()[static_cast<std::size_t>(bin)]);
  };
  colors.learn(bins_of({7, 7, -1, 8}, {-1, -1, 8, 7}), 3);
  CHECK(share(colors, 7) == doctest::Approx((2.0 / 3) / (2.0 / 3 + 0.5)).epsilon(1e-3));
  CHECK(share(colors, 8) == doctest::Approx((1.0 / 3) / (1.0 / 3 + 0.5)).epsilon(1e-3));
  const std::vector<float> before = colors.share();
  colors.learn(bins_of({-1, -1, -1, -1}, {-1, -1, -1, -1}), 3);
  CHECK(colors.share() == before);
  CHECK(std::all_of(before.begin(), before.end(), [](float value) { return value > 0 && value < 1; }));
}
