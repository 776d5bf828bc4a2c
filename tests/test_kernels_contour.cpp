// Lines across an object's contour: the colours along them, the edges they find and the rows these make.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>

#include "contour/color_histograms.hpp"
#include "contour/contour_points.hpp"
#include "holdfast/pose.hpp"
#include "solve/normal_equations.hpp"
#include "support/conditioned.hpp"
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
  kernel::hf_contour contour{};
  std::vector<float> share;

  Setting(Size size, Planes pixels) : level(level_of(size)), frame(std::move(pixels)), share(ColorHistograms::kBins) {
    contour.fx = static_cast<float>(level.camera.fx);
    contour.fy = static_cast<float>(level.camera.fy);
    contour.cx = static_cast<float>(level.camera.cx);
    contour.cy = static_cast<float>(level.camera.cy);
    contour.reach = kReach;
    contour.region = {0, 0, size.width, size.height};
    contour.radius = 1;
    contour.softness2 = 0.36F;
    contour.trust = 0.43F;
    contour.step = 1;
    contour.variance = 1;
    contour.beside = 2;
    contour.around = 6;
    move(Pose::Identity());
  }

  void move(const Pose& D) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) contour.d[4 * row + column] = static_cast<float>(D(row, column));
    }
  }

  Pose D() const {
    Pose D = Pose::Identity();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) D(row, column) = static_cast<double>(contour.d[4 * row + column]);
    }
    return D;
  }

  Eigen::Vector2d project(const Eigen::Vector3d& p) const {
    return {static_cast<double>(contour.fx) * p.x() / p.z() + static_cast<double>(contour.cx),
            static_cast<double>(contour.fy) * p.y() / p.z() + static_cast<double>(contour.cy)};
  }

  Eigen::Vector3d backproject(const Eigen::Vector2d& at, double z) const {
    return {(at.x() - static_cast<double>(contour.cx)) / static_cast<double>(contour.fx) * z,
            (at.y() - static_cast<double>(contour.cy)) / static_cast<double>(contour.fy) * z, z};
  }

  bool in_region(double x, double y) const {
    const kernel::hf_rect& r = contour.region;
    return x >= r.x && y >= r.y && x < r.x + r.width && y < r.y + r.height;
  }

  ReferenceLine line(const ContourPoint& point) const {
    ReferenceLine line;
    line.p = D() * point.p_camera.cast<double>();
    line.normal = (D().linear().topLeftCorner<2, 2>() * point.normal.cast<double>()).normalized();
    if (line.p.z() <= 0) return line;
    line.pixel = project(line.p);
    const double inside = static_cast<double>(point.inside), outside = static_cast<double>(point.outside);
    for (int k = -contour.reach; k <= contour.reach; ++k) {
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

std::optional<Edge> edge_by_shares(const kernel::hf_contour& o, const std::vector<Passed>& passed) {
  std::array<Eigen::Vector3d, 2> mean;
  double spread = static_cast<double>(HF_CONTOUR_NOISE2);
  for (const int side : {-1, 1}) {
    std::vector<Eigen::Vector3d> colors;
    for (int steps = o.beside; steps <= o.around; ++steps) {
      for (const Passed& pixel : passed) {
        if (pixel.k == side * steps) colors.push_back(pixel.color);
      }
    }
    if (colors.size() < 2) return std::nullopt;
    // Each weighs by its likeness to the mean of those nearer to the contour.
    std::vector<double> weights;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double all = 0;
    for (const Eigen::Vector3d& color : colors) {
      const double unlike = all > 0 ? (color - sum / all).squaredNorm() : 0;
      weights.push_back(1 / (1 + unlike / static_cast<double>(HF_CONTOUR_ALIKE2)));
      sum += weights.back() * color;
      all += weights.back();
    }
    const Eigen::Vector3d middle = sum / all;
    for (std::size_t i = 0; i < colors.size(); ++i) spread += weights[i] * (colors[i] - middle).squaredNorm() / all;
    mean[side > 0 ? 1 : 0] = middle;
  }
  const Eigen::Vector3d across = mean[0] - mean[1];
  const double contrast2 = std::max(across.squaredNorm(), 1e-6);
  Edge edge{0, spread / contrast2};
  for (const Passed& pixel : passed) {
    if (std::abs(pixel.k) > o.beside) continue;
    const double share = std::clamp(across.dot(pixel.color - mean[1]) / contrast2, -0.5, 1.5);
    const double ramp = std::clamp(pixel.beyond / static_cast<double>(HF_CONTOUR_HALF_EDGE), -1.0, 1.0);
    const double window = std::max(0.0, 1 - std::pow(pixel.beyond / (o.beside + 0.5), 2));
    edge.offset += window * (share - (1 - ramp) / 2);
  }
  return edge;
}

/// d(pixel along the normal) / d(conditioned twist), by the chain rule.
Vector6 reference_row(const Setting& setting, const ContourPoint& point, const ReferenceLine& line) {
  const kernel::hf_contour& o = setting.contour;
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

double soft_sign(double x, const kernel::hf_contour& o) {
  return x / std::sqrt(x * x + static_cast<double>(o.softness2));
}

/// Nothing where too few pixels of the line are seen; `unsure` where that hangs by float.
std::optional<Told> reference_told(const Setting& setting, const ContourPoint& point, bool& unsure) {
  const kernel::hf_contour& o = setting.contour;
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
  const double least = static_cast<double>(HF_CONTOUR_LEAST_PIXELS);
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
    // The more colours vary beside their contrast, the more the edge is where colours alone put it.
    const double trust = edge ? 1 / (1 + edge->doubt / static_cast<double>(HF_CONTOUR_DOUBT)) : 0;
    told.distance = edge ? trust * edge->offset + (1 - trust) * by_colors : 0;
    const double agreed = 1 / (1 + by_colors * by_colors / static_cast<double>(HF_CONTOUR_AGREED2));
    told.weight *= edge ? agreed / (static_cast<double>(HF_CONTOUR_LEAST_DOUBT) + edge->doubt) : 0;
  }
  const double far2 = static_cast<double>(o.far2);
  if (far2 > 0) told.weight *= far2 / (far2 + told.distance * told.distance);
  told.row = reference_row(setting, point, line);
  return told;
}

/// Runs a kernel over the lines; work-items beyond them must write nothing.
template <typename T>
std::vector<T> run_lines(const Device::Impl& device, const Setting& setting, const std::vector<ContourPoint>& points,
                         const char* name, std::size_t values, T untouched) {
  const std::size_t items = (points.size() + HF_GROUP - 1) / HF_GROUP * HF_GROUP;
  const cl::Buffer frame = upload(device, to_memory(setting.frame, setting.level)), lines = upload(device, points);
  const cl::Buffer share = upload(device, setting.share);
  const cl::Buffer out = upload(device, std::vector<T>(items * values, untouched));
  kernel::hf_contour contour = setting.contour;
  contour.count = static_cast<int>(points.size());
  cl::Kernel kernel = device.kernel(name);
  if (std::is_same_v<T, int>) {
    set_arguments(kernel, frame, setting.level.layout, lines, contour, out);
  } else {
    set_arguments(kernel, frame, setting.level.layout, lines, contour, share, out);
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
                            const std::vector<ContourPoint>& points) {
  return run_lines<int>(device, setting, points, "contour_colors", kBinsOfLine, static_cast<int>(kUntouched));
}

std::vector<float> run_constraints(const Device::Impl& device, const Setting& setting,
                                   const std::vector<ContourPoint>& points) {
  return run_lines<float>(device, setting, points, "contour_constraints", HF_CONTOUR_SUMS, kUntouched);
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
  setting.contour.center[0] = 0.02F;
  setting.contour.center[1] = -0.03F;
  setting.contour.center[2] = 0.55F;
  setting.contour.radius = 0.13F;
  if (size.width > 8) setting.contour.region = {1, 2, size.width - 3, size.height - 3};
  return setting;
}

/// Lines that land around and beyond the region when D has moved them, none of which float may see otherwise.
std::vector<ContourPoint> random_points(const Setting& setting, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  const Pose D_inverse = setting.D().inverse(Eigen::Affine);
  const double width = setting.frame.width, height = setting.frame.height;
  std::vector<ContourPoint> points;
  while (points.size() < kLines) {
    const auto kind = points.size() % 10;
    const double around = kind == 0 ? 40 : kind < 4 ? 6 : 0;
    const Eigen::Vector2d at((width + 2 * around) * uniform(random) - around - 0.5,
                             (height + 2 * around) * uniform(random) - around - 0.5);
    const double angle = 2 * std::numbers::pi * uniform(random);
    ContourPoint point;
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
  CHECK(std::abs(value(HF_CONTOUR_DISTANCE) - told.distance) < tolerance);
  CHECK(std::abs(value(HF_CONTOUR_INFORMATION) - told.information) < tolerance);
  CHECK(std::abs(value(HF_CONTOUR_AGREEMENT) - told.agreement) < tolerance);
  const double most_weight = std::max(1.0, told.weight), most_distance = std::max(1.0, std::abs(told.distance));
  CHECK(std::abs(value(HF_CONTOUR_W) - told.weight) < tolerance * most_weight);
  CHECK(std::abs(value(HF_CONTOUR_WRR) - told.weight * told.distance * told.distance) <
        2 * tolerance * most_weight * most_distance * most_distance);
  const double most = told.row.cwiseAbs().maxCoeff();
  int n = HF_SUM_A;
  double off_A = 0, off_h = 0, off_outward = 0;
  for (int a = 0; a < 6; ++a) {
    for (int b = a; b < 6; ++b) off_A = std::max(off_A, std::abs(value(n++) - told.weight * told.row(a) * told.row(b)));
    off_h = std::max(off_h, std::abs(value(HF_SUM_H + a) - told.weight * told.row(a) * told.distance));
    off_outward = std::max(off_outward, std::abs(value(HF_CONTOUR_OUTWARD + a) - told.weight * told.row(a)));
  }
  CHECK(n == HF_SUM_H);
  CHECK(off_A < 2 * tolerance * most_weight * most * most);
  CHECK(off_h < 2 * tolerance * most_weight * most * most_distance);
  CHECK(off_outward < 2 * tolerance * most_weight * most);
  for (int i = HF_CONTOUR_OUTWARD + 6; i < HF_CONTOUR_SUMS; ++i) CHECK(line[i] == 0.0F);
}

void check_constraints(const Device::Impl& device, Size size) {
  Setting setting = random_setting(size, 3);
  std::vector<ContourPoint> points = random_points(setting, 4);
  points[5].p_camera = (setting.D().inverse(Eigen::Affine) * Eigen::Vector3d(0, 0, -0.5)).cast<float>();
  // A pixel's place on a large frame has fewer bits left behind the point.
  const double tolerance = 1e-5 + 4e-7 * std::max(size.width, size.height);
  for (int variant = 0; variant < 8; ++variant) {
    CAPTURE(variant);
    setting.contour.by_shares = variant & 1;
    setting.contour.far2 = variant & 2 ? 1.7F : 0.0F;
    setting.contour.step = variant & 4 ? 0.5F : 1.0F;
    setting.contour.variance = variant & 4 ? 0.25F : 1.0F;
    setting.contour.beside = variant & 2 ? 1 : 2;
    setting.contour.around = variant & 2 ? 4 : 6;
    const std::vector<float> sums = run_constraints(device, setting, points);
    std::size_t telling = 0, silent = 0, weighing = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      CAPTURE(i);
      const float* line = sums.data() + i * HF_CONTOUR_SUMS;
      bool unsure = false;
      const std::optional<Told> told = reference_told(setting, points[i], unsure);
      REQUIRE(!unsure);
      if (told) {
        check_told(line, *told, tolerance);
      } else {
        CHECK(std::all_of(line, line + HF_CONTOUR_SUMS, [](float value) { return value == 0.0F; }));
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
  std::vector<ContourPoint> points = random_points(setting, 6);
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
  const std::vector<ContourPoint> points = random_points(setting, 8);
  Conditioning conditioning;
  for (int axis = 0; axis < 3; ++axis) {
    conditioning.p_camera_center(axis) = static_cast<double>(setting.contour.center[axis]);
  }
  conditioning.radius = static_cast<double>(setting.contour.radius);
  const std::vector<float> sums = run_constraints(device, setting, points);
  int checked = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    CAPTURE(i);
    const float* line = sums.data() + i * HF_CONTOUR_SUMS;
    const double weight = static_cast<double>(line[HF_CONTOUR_W]),
                 distance = static_cast<double>(line[HF_CONTOUR_DISTANCE]);
    if (weight < 1e-3 || std::abs(distance) < 0.1) continue;
    ++checked;
    const Eigen::Vector2d normal = setting.line(points[i]).normal;
    const auto along = [&](const Vector6& y) {
      const Pose moved = setting.D() * exp_se3(twist_of(conditioning, y));
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

/// What it is for, in words: a contour drawn beside the edge of two colours is told how far and which way it is off.
void check_found_edge(const Device::Impl& device, Size size) {
  if (size.width < 13) return;
  const Eigen::Vector2d normal(std::cos(0.4), std::sin(0.4)), middle(0.5 * size.width, 0.5 * size.height);
  const Eigen::Vector3d inside(0.8, 0.3, 0.2), outside(0.2, 0.5, 0.7);
  const Planes frame = two_colors(size, normal, middle, inside, outside);
  Setting setting(size, frame);
  setting.contour.variance = 0.25F;
  setting.contour.step = 0.5F;
  for (const bool swapped : {false, true}) {
    setting.share.assign(ColorHistograms::kBins, 0.5F);
    setting.share[static_cast<std::size_t>(bin_of(inside))] = swapped ? 0.02F : 0.98F;
    setting.share[static_cast<std::size_t>(bin_of(outside))] = swapped ? 0.98F : 0.02F;
    for (const bool by_shares : {false, true}) {
      setting.contour.by_shares = by_shares ? 1 : 0;
      for (const double offset : {-1.0, -0.4, 0.0, 0.3, 0.8}) {
        CAPTURE(offset);
        std::vector<ContourPoint> points;
        for (int i = 0; i < 9; ++i) {
          ContourPoint point;
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
          const float* line = sums.data() + i * HF_CONTOUR_SUMS;
          distance += static_cast<double>(line[HF_CONTOUR_DISTANCE]) / static_cast<double>(points.size());
          information += static_cast<double>(line[HF_CONTOUR_INFORMATION]) / static_cast<double>(points.size());
          agreement += static_cast<double>(line[HF_CONTOUR_AGREEMENT]) / static_cast<double>(points.size());
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

/// A rim four pixels wide of another colour, as on a thing that is seen from its end: the edge is the rim's outer one.
void check_found_rim(const Device::Impl& device, Size size) {
  if (size.width < 25) return;
  const Eigen::Vector2d normal(std::cos(0.4), std::sin(0.4)), middle(0.5 * size.width, 0.5 * size.height);
  const Eigen::Vector3d body(0.8, 0.2, 0.2), rim(0.2, 0.7, 0.8), outside(0.5, 0.5, 0.5);
  Planes frame = two_colors(size, normal, middle - 4 * normal, body, rim);
  const Planes edge = two_colors(size, normal, middle, rim, outside);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      if (normal.dot(Eigen::Vector2d(x, y) - middle) < -2) continue;
      for (int channel = 0; channel < 3; ++channel) frame.at(x, y, channel) = edge.get(x, y, channel);
    }
  }
  Setting setting(size, frame);
  setting.contour.variance = 0.25F;
  setting.contour.step = 0.5F;
  setting.contour.by_shares = 1;
  for (const Eigen::Vector3d& color : {body, rim}) setting.share[static_cast<std::size_t>(bin_of(color))] = 0.98F;
  setting.share[static_cast<std::size_t>(bin_of(outside))] = 0.02F;
  for (const double offset : {-0.4, 0.0, 0.3}) {
    CAPTURE(offset);
    ContourPoint point;
    point.p_camera = setting.backproject(middle - offset * normal, 0.6).cast<float>();
    point.normal = normal.cast<float>();
    point.inside = point.outside = kReach;
    const std::vector<float> sums = run_constraints(device, setting, {point});
    CHECK(std::abs(static_cast<double>(sums[HF_CONTOUR_DISTANCE]) - offset) < 0.25);
  }
}

}  // namespace

SMALL_AND_LARGE("constraints of lines across the contour", check_constraints)
SMALL_AND_LARGE("colours of lines across the contour", check_colors)
SMALL_AND_LARGE("a line's row is the slope of its pixel", check_row)
SMALL_AND_LARGE("a line finds the edge of two colours", check_found_edge)
SMALL_AND_LARGE("a line finds the outer edge of a narrow rim", check_found_rim)
