#include "contour/outline_stage.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/stopwatch.hpp"
#include "holdfast/tracker.hpp"
#include "solve/covariance.hpp"

namespace holdfast {
namespace {

/// Least side of the object on a level whose outline is still worth following, pixels, and levels above the finest
/// that are.
constexpr double kLeastSide = 24;
constexpr int kMostCoarser = 2;
constexpr std::size_t kLeastLines = 12;
/// Solutions of one search, at most, and the step that ends them, pixels of the level.
constexpr int kSolutions = 2;
constexpr double kConverged = 0.02;
/// A silhouette is drawn anew when it has moved by more than this many pixels of the level since.
constexpr double kRedraw = 0.25;
/// The uncertainty of the view drawn, object radii and radians, which weighs against lines of which so many count as
/// one: what the outline leaves free stays as it is.
constexpr double kFreeDeviation = 0.08, kLinesPerObservation = 20;
/// Of the covariance: lines whose errors are alike, and what blur, light and colours may move all edges by at once,
/// pixels.
constexpr double kAlike = 12, kOutward = 0.2;
/// What an outline tells of a turn, of what it tells of the one that it shows best, below which it is taken to tell
/// nothing: rims of round things seem to move a little where they are cut into facets and pixels.
constexpr double kHiddenTurn = 0.012;
/// Share of all that an outline tells, below which it tells nothing of a motion that nothing else tells of either.
constexpr double kNothingTold = 0.005;
/// Share of the start's own weight that keeps sums invertible.
constexpr double kLeftFree = 1e-3;

/// By colours alone on coarser levels and first on the finest; then closer; then by what pixels at the edge show.
constexpr OutlineSearch kCoarse{.step = 1, .deviation = 1, .far = 2, .by_shares = false};
constexpr OutlineSearch kClose{.step = 0.5, .deviation = 0.5, .far = 2, .by_shares = false};
constexpr OutlineSearch kClosest{.step = 0.5, .deviation = 0.5, .far = 1, .by_shares = true};
constexpr std::array<OutlineSearch, 6> kOnFinest{kCoarse, kClose, kClose, kClosest, kClosest, kClosest};
/// From a pose that texture found, at most: once more only where a search led away from what it had drawn.
constexpr int kNearbySearches = 3;

}  // namespace

void forget(Matrix6& information, const Twist& motion) {
  const Twist told = information * motion;
  information -= told * told.transpose() / std::max(motion.dot(told), 1e-12);
}

bool hides(const OutlineEstimate& outline, const Twist& motion) {
  return motion.dot(outline.information * motion) < kNothingTold * outline.information.trace() * motion.squaredNorm();
}

OutlineStage::OutlineStage(const Device::Impl& device, const std::vector<Level>& levels, const Extent& extent,
                           ViewTemplate& view, DeviceImage& image)
    : levels_(levels), extent_(extent), view_(view), image_(image), constraints_(device, levels) {
  depth_.resize(levels[0].elements);
}

bool OutlineStage::draw(const Pose& T_camera_object, int level_index) {
  level_drawn_ = -1;
  T_drawn_ = T_camera_object;
  D_ = Pose::Identity();
  const Level& level = levels_[static_cast<std::size_t>(level_index)];
  const Rect object = view_.bounds(T_camera_object);
  if (object.empty()) return false;
  const Rect wanted = grown({object.x >> level_index, object.y >> level_index, (object.width >> level_index) + 2,
                             (object.height >> level_index) + 2},
                            OutlineConstraints::kReach + 4);
  const Rect rect = aligned(wanted, 4, level.padded_width, level.padded_height);
  if (rect.empty()) return false;
  {
    const Stopwatch watch(effort_.render_ms);
    drawn_.range = view_.renderer().render(T_camera_object, level.camera, rect, {nullptr, depth_.data(), rect.width});
  }
  drawn_.depth = depth_.data();
  drawn_.rect = rect;
  level_drawn_ = level_index;
  const Stopwatch watch(effort_.lines_ms);
  constraints_.set_points(drawn_, level_index);
  return constraints_.count() >= kLeastLines;
}

int OutlineStage::coarsest(const Pose& T_camera_object, int finest) const {
  const Rect object = view_.bounds(T_camera_object);
  const double side = std::min(object.width, object.height);
  const int last = std::min(static_cast<int>(levels_.size()) - 1, finest + kMostCoarser);
  int level = finest;
  while (level < last && side / (1 << (level + 1)) >= kLeastSide) ++level;
  return level;
}

ConstraintSums OutlineStage::with_expectation(ConstraintSums sums, const Expectation& expected) const {
  const bool free = expected.deviation <= 0;
  const double deviation = free ? kFreeDeviation : expected.deviation;
  const double weight = std::max(1.0, sums.rows) / (kLinesPerObservation * deviation * deviation);
  const Pose to_expected = D_.inverse() * (free ? Pose::Identity() : expected.T_camera_object * T_drawn_.inverse());
  sums.A += weight * Matrix6::Identity();
  sums.h += weight * conditioning().conditioned(log_se3(to_expected));
  return sums;
}

double OutlineStage::motion(int level, const Pose& D_from, const Pose& D_to) const {
  return corner_motion(extent_, levels_[static_cast<std::size_t>(level)].camera, D_from * T_drawn_, D_to * T_drawn_);
}

bool OutlineStage::approach(OutlineEstimate& estimate, int level, const OutlineSearch& search,
                            const Expectation& expected) {
  if (level != level_drawn_ || motion(level, Pose::Identity(), D_) > kRedraw) {
    estimate.solved = draw(estimate.T_camera_object, level);
    if (!estimate.solved) {
      estimate.visible_pixels = visible_pixels();
      return false;
    }
  }
  const Stopwatch watch(effort_.solve_ms);
  for (int i = 0; i < kSolutions; ++i) {
    estimate.sums = constraints_.evaluate(image_, D_, conditioning(), search);
    const Solution solution = solve(with_expectation(estimate.sums, expected), conditioning(), 0);
    ++effort_.solved_systems;
    estimate.solved = solution.solved;
    if (!solution.solved) {
      estimate.visible_pixels = visible_pixels();
      return false;
    }
    const Pose before = D_;
    D_ = renormalized(D_ * exp_se3(solution.twist));
    if (motion(level, before, D_) < kConverged) break;
  }
  estimate.T_camera_object = renormalized(D_ * T_drawn_);
  return true;
}

void OutlineStage::measure(OutlineEstimate& estimate, const OutlineSearch& search) {
  const Stopwatch watch(effort_.solve_ms);
  OutlineSums& sums = estimate.sums;
  sums = constraints_.evaluate(image_, D_, conditioning(), search);
  estimate.conditioning = conditioning();
  estimate.visible_pixels = visible_pixels();
  estimate.score = sums.agreement * sums.near / std::max(1.0, sums.lines);
  const double square = sums.weighted_square / std::max(1.0, sums.rows - 6);
  const double prior = 1 / (kFreeDeviation * kFreeDeviation);
  const Matrix6 outline = sums.A / (kAlike * std::max(square, 1e-9));
  estimate.covariance = (outline + prior * Matrix6::Identity()).ldlt().solve(Matrix6::Identity());
  const Matrix6 A = sums.A + kLeftFree * prior * Matrix6::Identity();
  const Twist outward = kOutward * A.ldlt().solve(sums.outward);
  estimate.covariance += outward * outward.transpose();
  const Matrix6 alone = (outline + kLeftFree * prior * Matrix6::Identity()).ldlt().solve(Matrix6::Identity());
  estimate.information = symmetric_inverse(alone + outward * outward.transpose());
  forget_hidden_turns(estimate);
}

void OutlineStage::forget_hidden_turns(OutlineEstimate& estimate) {
  const Matrix6 I = estimate.information;
  const Eigen::Matrix3d shift_per_turn = -I.topLeftCorner<3, 3>().ldlt().solve(I.topRightCorner<3, 3>());
  const Eigen::Matrix3d turns = I.bottomRightCorner<3, 3>() + I.bottomLeftCorner<3, 3>() * shift_per_turn;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> shown(0.5 * (turns + turns.transpose()));
  estimate.hidden_turn_count = 0;
  for (int i = 0; i < 2 && shown.eigenvalues()(i) < kHiddenTurn * shown.eigenvalues()(2); ++i) {
    Twist motion;
    motion << shift_per_turn * shown.eigenvectors().col(i), shown.eigenvectors().col(i);
    forget(estimate.information, motion);
    estimate.hidden_turns.col(estimate.hidden_turn_count++) = motion;
  }
}

OutlineEstimate OutlineStage::estimate(const Pose& T_start, int finest, double deviation) {
  const Expectation expected{T_start, deviation};
  OutlineEstimate estimate;
  estimate.T_camera_object = T_start;
  level_drawn_ = -1;
  for (int level = coarsest(T_start, finest); level > finest; --level) {
    if (!approach(estimate, level, kCoarse, expected)) return estimate;
  }
  for (const OutlineSearch& search : kOnFinest) {
    if (!approach(estimate, finest, search, expected)) return estimate;
  }
  measure(estimate, kOnFinest.back());
  return estimate;
}

OutlineEstimate OutlineStage::estimate_nearby(const Pose& T_start, int finest) {
  OutlineEstimate estimate;
  estimate.T_camera_object = T_start;
  level_drawn_ = -1;
  for (int i = 0; i < kNearbySearches; ++i) {
    if (!approach(estimate, finest, kClosest, {})) return estimate;
    if (motion(finest, Pose::Identity(), D_) <= kRedraw) break;
  }
  measure(estimate, kClosest);
  return estimate;
}

void OutlineStage::set_colors(const ObjectColors& colors) {
  colors_ = colors;
  constraints_.set_colors(colors_);
}

void OutlineStage::learn(const Pose& T_camera_object, int finest) {
  if (!draw(T_camera_object, std::min(finest + 1, coarsest(T_camera_object, finest)))) return;
  const Stopwatch watch(effort_.solve_ms);
  constraints_.learn(image_, Pose::Identity(), conditioning(), colors_);
  constraints_.set_colors(colors_);
}

void OutlineStage::classify(const Pose& T_camera_object, int finest, std::vector<std::uint8_t>& classes) {
  draw(T_camera_object, finest);
  if (level_drawn_ < 0) return;
  constraints_.evaluate(image_, D_, conditioning(), kClosest);
  const Level& first = levels_[0];
  const int side = 1 << level_drawn_;
  const auto set = [&](int x, int y, PixelClass value) {
    for (int v = y * side; v < std::min((y + 1) * side, first.height); ++v) {
      for (int u = x * side; u < std::min((x + 1) * side, first.width); ++u) {
        classes[static_cast<std::size_t>(v) * static_cast<std::size_t>(first.width) + static_cast<std::size_t>(u)] =
            static_cast<std::uint8_t>(value);
      }
    }
  };
  const Rect& rect = drawn_.rect;
  for (int y = 0; y < rect.height; ++y) {
    for (int x = 0; x < rect.width; ++x) {
      if (drawn_.depth[y * rect.width + x] < 1.0F) set(rect.x + x, rect.y + y, PixelClass::unusable);
    }
  }
  constraints_.for_each_line([&](const Eigen::Vector2d& pixel, bool near, bool telling) {
    const int x = static_cast<int>(std::lround(pixel.x())), y = static_cast<int>(std::lround(pixel.y()));
    if (x < 0 || y < 0) return;
    set(x, y, near ? PixelClass::used : telling ? PixelClass::rejected_magnitude : PixelClass::no_gradient);
  });
}

int OutlineStage::visible_pixels() const {
  if (level_drawn_ < 0) return 0;
  const Level& level = levels_[static_cast<std::size_t>(level_drawn_)];
  int count = 0;
  for (int y = 0; y < drawn_.rect.height && drawn_.rect.y + y < level.height; ++y) {
    const float* row = drawn_.depth + static_cast<std::ptrdiff_t>(y) * drawn_.rect.width;
    const int width = std::min(drawn_.rect.width, level.width - drawn_.rect.x);
    count += static_cast<int>(std::count_if(row, row + width, [](float depth) { return depth < 1.0F; }));
  }
  return count << (2 * level_drawn_);
}

}  // namespace holdfast
