// Edges of the frame on lines across a model's edges, against a plain loop in double and a picture of one edge.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include "support/kernel_checks.hpp"

namespace {

using namespace holdfast;
using namespace holdfast::test;
using reference::Planes;

/// Not a multiple of a group, so that some work-items have no line.
constexpr std::size_t kLines = 101;
constexpr float kUntouched = 7.0F;
constexpr int kReach = HF_EDGE_REACH;
constexpr std::size_t kValues = HF_EDGE_CANDIDATES * HF_EDGE_CANDIDATE;
/// Closer comparisons may turn out otherwise in float: of pixels' places, and of squared steps beside each other.
constexpr double kMargin = 1e-3, kClose = 1e-4;

struct Line {
  Eigen::Vector2d at, normal;
  Eigen::Vector3d usual = Eigen::Vector3d::Zero();
  bool known = false;
};

struct Candidate {
  double offset = 0, weight = 0;
  Eigen::Vector3d step = Eigen::Vector3d::Zero();
};

/// Frame between pixels, or none where one of the four is outside of the region. `unsure`: float may see another pixel.
std::optional<Eigen::Vector4d> between(const Planes& frame, const kernel::hf_rect& region, const Eigen::Vector2d& at,
                                       bool& unsure) {
  // The value between pixels has no jump at a pixel, whether it can be had does: at the region's border.
  const double nearest_border =
      std::min({std::abs(at.x() - region.x), std::abs(at.x() - (region.x + region.width - 1)),
                std::abs(at.y() - region.y), std::abs(at.y() - (region.y + region.height - 1))});
  unsure |= nearest_border < kMargin;
  const int x = static_cast<int>(std::floor(at.x())), y = static_cast<int>(std::floor(at.y()));
  if (x < region.x || y < region.y || x + 1 >= region.x + region.width || y + 1 >= region.y + region.height) return {};
  Eigen::Vector4d value;
  for (int c = 0; c < 4; ++c) value(c) = reference::bilinear(frame, at.x(), at.y(), c);
  return value;
}

/// Equation 32: colour at k pixels along the normal, of three places along the edge; none where the frame has none.
std::optional<Eigen::Vector3d> smoothed(const Planes& frame, const kernel::hf_rect& region, const Line& line, int k,
                                        bool& unsure) {
  const Eigen::Vector2d along(-line.normal.y(), line.normal.x());
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  for (const int side : {-1, 0, 1}) {
    const auto value = between(frame, region, line.at + k * line.normal + side * along, unsure);
    if (value) sum += (side == 0 ? 0.5 : 0.25) * *value;
  }
  unsure |= std::abs(sum(3) - 0.99) < kClose;
  if (sum(3) <= 0.99) return {};
  return sum.head<3>();
}

/// Equations 32 and 33, in order of weight.
std::vector<Candidate> reference_candidates(const Planes& frame, const kernel::hf_rect& region, const Line& line,
                                            bool& unsure) {
  std::array<std::optional<Eigen::Vector3d>, 2 * kReach + 5> color;
  for (int k = -kReach - 2; k <= kReach + 2; ++k)
    color[static_cast<std::size_t>(k + kReach + 2)] = smoothed(frame, region, line, k, unsure);
  std::array<Eigen::Vector3d, 2 * kReach + 3> steps;
  std::array<double, 2 * kReach + 3> square{};
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    steps[i].setZero();
    if (!color[i] || !color[i + 1] || !color[i + 2]) continue;
    steps[i] = *color[i + 2] - *color[i];
    square[i] = steps[i].squaredNorm();
    sum += square[i];
    count += 1;
  }
  std::vector<Candidate> all;
  if (count < kReach) return all;
  const double noise = static_cast<double>(HF_EDGE_NOISE2);
  for (std::size_t i = 1; i + 1 < steps.size(); ++i) {
    unsure |= std::abs(square[i] - noise) < kClose * noise;
    if (square[i] <= noise) continue;
    for (const std::size_t beside : {i - 1, i + 1})
      unsure |= square[beside] > 0 && std::abs(square[i] - square[beside]) < kClose * square[i];
    if (square[i] < square[i - 1] || square[i] <= square[i + 1]) continue;
    Candidate candidate;
    candidate.step = steps[i];
    candidate.weight = square[i] / (square[i] + sum / count + noise);
    if (line.known) {
      const double like = 2 * steps[i].dot(line.usual) / (square[i] + line.usual.squaredNorm());
      candidate.weight *= std::max(static_cast<double>(HF_EDGE_UNLIKE), like);
    }
    // The top of the parabola through three lengths, found as where its derivative is zero.
    const double a = std::sqrt(square[i - 1]), b = std::sqrt(square[i]), c = std::sqrt(square[i + 1]);
    const double second = a + c - 2 * b, first = 0.5 * (c - a);
    unsure |= std::abs(second) < kMargin;
    candidate.offset = static_cast<double>(i) - kReach - 1 + std::clamp(-first / second, -0.5, 0.5);
    all.push_back(candidate);
  }
  std::stable_sort(all.begin(), all.end(), [](const Candidate& p, const Candidate& q) { return p.weight > q.weight; });
  for (std::size_t i = 1; i < all.size(); ++i) unsure |= all[i - 1].weight - all[i].weight < 1e-5;
  if (all.size() > HF_EDGE_CANDIDATES) all.resize(HF_EDGE_CANDIDATES);
  return all;
}

/// Runs the kernel; work-items beyond the lines must write nothing.
std::vector<float> run(const Device::Impl& device, const Level& level, const Planes& frame,
                       const kernel::hf_rect& region, const std::vector<Line>& lines) {
  const std::size_t items = (lines.size() + HF_GROUP - 1) / HF_GROUP * HF_GROUP;
  std::vector<float> packed;
  for (const Line& line : lines) {
    for (const double value : {line.at.x(), line.at.y(), line.normal.x(), line.normal.y(), line.usual.x(),
                               line.usual.y(), line.usual.z(), line.known ? 1.0 : 0.0})
      packed.push_back(static_cast<float>(value));
  }
  const cl::Buffer pixels = upload(device, to_memory(frame, level)), in = upload(device, packed);
  const cl::Buffer out = upload(device, std::vector<float>(items * kValues, kUntouched));
  kernel::hf_edges edges{};
  edges.region = region;
  edges.count = static_cast<int>(lines.size());
  cl::Kernel kernel = device.kernel("edge_candidates");
  set_arguments(kernel, pixels, level.layout, in, edges, out);
  device.queue.enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(items),
                                    cl::NDRange(device.strips ? 1 : HF_GROUP));
  std::vector<float> result = download<float>(device, out, items * kValues);
  const auto end = result.begin() + static_cast<std::ptrdiff_t>(lines.size() * kValues);
  CHECK(std::all_of(end, result.end(), [](float value) { return value == kUntouched; }));
  result.erase(end, result.end());
  return result;
}

/// Noise of every strength, and a pixel here and there that was not recorded.
Planes noisy_frame(Size size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  Planes frame(size.width, size.height, HF_PIXEL);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double strength = x > size.width / 2 ? 0.5 : 0.02;
      for (int c = 0; c < 3; ++c) frame.at(x, y, c) = as_float(0.3 + strength * uniform(random));
      frame.at(x, y, 3) = uniform(random) < 0.003 ? 0 : 1;
    }
  }
  return frame;
}

/// Lines that lie inside, across the border of and beyond the region, none of which float may see otherwise.
std::vector<Line> random_lines(const Planes& frame, const kernel::hf_rect& region, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<Line> lines;
  while (lines.size() < kLines) {
    const double around = lines.size() % 10 == 0 ? std::max(30, frame.width / 2) : 2;
    Line line;
    line.at = {as_float((frame.width + 2 * around) * uniform(random) - around),
               as_float((frame.height + 2 * around) * uniform(random) - around)};
    const double angle = 2 * std::numbers::pi * uniform(random);
    line.normal = {as_float(std::cos(angle)), as_float(std::sin(angle))};
    line.known = lines.size() % 2 == 1;
    for (int c = 0; c < 3; ++c) line.usual(c) = as_float(0.4 * uniform(random) - 0.2);
    bool unsure = false;
    reference_candidates(frame, region, line, unsure);
    if (!unsure) lines.push_back(line);
  }
  return lines;
}

void check_candidates(const Device::Impl& device, Size size) {
  const Planes frame = noisy_frame(size, 11);
  kernel::hf_rect region{0, 0, size.width, size.height};
  if (size.width > 8) region = {1, 2, size.width - 3, size.height - 3};
  const std::vector<Line> lines = random_lines(frame, region, 12);
  const std::vector<float> found = run(device, level_of(size), frame, region, lines);
  std::size_t silent = 0, full = 0, candidates = 0;
  double off_place = 0, off_weight = 0, off_step = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    CAPTURE(i);
    bool unsure = false;
    const std::vector<Candidate> expected = reference_candidates(frame, region, lines[i], unsure);
    REQUIRE(!unsure);
    for (std::size_t j = 0; j < HF_EDGE_CANDIDATES; ++j) {
      CAPTURE(j);
      const float* value = found.data() + i * kValues + j * HF_EDGE_CANDIDATE;
      if (j >= expected.size()) {
        CHECK(std::all_of(value, value + HF_EDGE_CANDIDATE, [](float v) { return v == 0.0F; }));
        continue;
      }
      off_place = std::max(off_place, std::abs(static_cast<double>(value[0]) - expected[j].offset));
      off_weight = std::max(off_weight, std::abs(static_cast<double>(value[1]) - expected[j].weight));
      for (int c = 0; c < 3; ++c)
        off_step = std::max(off_step, std::abs(static_cast<double>(value[2 + c]) - expected[j].step(c)));
      CHECK(std::all_of(value + 5, value + HF_EDGE_CANDIDATE, [](float v) { return v == 0.0F; }));
      ++candidates;
    }
    silent += expected.empty() ? 1 : 0;
    full += expected.size() == HF_EDGE_CANDIDATES ? 1 : 0;
  }
  CHECK(off_place < 1e-3);
  CHECK(off_weight < 1e-4);
  CHECK(off_step < 1e-4);
  CHECK(silent >= 3);
  if (size.width > 100) CHECK(full >= 50);
  if (size.width > 1) CHECK(candidates >= 10);
  CHECK(run(device, level_of(size), frame, region, lines) == found);
}

/// A straight edge of two colours as pixels with an area see it: where it is, and which way it steps.
void check_edge_of_two_colors(const Device::Impl& device, Size size) {
  if (size.width < 100) return;
  const Eigen::Vector2d normal = Eigen::Vector2d(0.8, -0.6), middle(0.5 * size.width, 0.5 * size.height);
  const Eigen::Vector3d before(0.7, 0.3, 0.2), beyond(0.3, 0.4, 0.6);
  const Planes frame = two_colors(size, normal, middle, before, beyond);
  std::vector<Line> lines;
  std::vector<double> offsets;
  for (int i = 0; i < 60; ++i) {
    offsets.push_back(8.5 * std::sin(0.7 * i));
    Line line;
    line.at = middle + (1.3 * i - 40) * Eigen::Vector2d(0.6, 0.8) - offsets.back() * normal;
    line.normal = normal;
    line.known = i % 3 > 0;
    line.usual = (i % 3 == 1 ? 1 : -1) * (beyond - before);  // its own step, or that of an edge the other way round
    lines.push_back(line);
  }
  const std::vector<float> found = run(device, level_of(size), frame, {0, 0, size.width, size.height}, lines);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    CAPTURE(i);
    const float* best = found.data() + i * kValues;
    CHECK(std::abs(static_cast<double>(best[0]) - offsets[i]) < 0.1);
    const Eigen::Vector3d step = Eigen::Vector3f(best[2], best[3], best[4]).cast<double>();
    CHECK((step - (beyond - before)).norm() < 0.35 * (beyond - before).norm());
    CHECK((best[1] > 0.6F) == (i % 3 < 2));  // it stands out, unless it is known to look otherwise
    CHECK(best[HF_EDGE_CANDIDATE + 1] < 0.2F * best[1]);
  }
}

}  // namespace

SMALL_AND_LARGE("edges of the frame on lines across a model's", check_candidates)

TEST_CASE("a line finds where two colours meet, and doubts an edge that looks unlike the usual one") {
  check_large(check_edge_of_two_colors);
}
