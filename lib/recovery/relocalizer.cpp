#include "recovery/relocalizer.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/turns.hpp"
#include "recovery/mirrored_tilt.hpp"

namespace holdfast {
namespace {

/// Least side of the object on a level that is still worth comparing there, and its least diameter on the level that
/// the whole picture is searched on, pixels: coarser is cheaper, and appearances may be farther apart.
constexpr double kLeastSide = 20, kLeastDiameter = 10;
/// Pixels of the view that a place is scored with, about.
constexpr double kScoredPixels = 200;
/// Appearances that a frame takes on at least and at most.
constexpr int kFewestAppearances = 6, kMostAppearances = 32;
/// Nominal cost of a view drawn and searched at a place, and over the whole picture a pixel: milliseconds. Fixed, so
/// that results do not depend on how fast the machine is.
constexpr double kViewCost = 0.2, kShiftCost = 2e-5;
/// What a candidate is turned by, radians, and brought nearer or farther by, as a share, in each round.
constexpr std::array<double, 2> kTurns = {0.2, 0.1}, kStretches = {0.1, 0.05};
/// Distances that it is believed at, as shares of the last one: too far away, anything looks like it.
constexpr double kNearest = 0.6, kFarthest = 1.7;
/// Pixels that a closer look may move a candidate by, and one from the last frame.
constexpr int kCloserReach = 4, kTurnedReach = 2, kLastReach = 10;
/// What is found is compared with itself turned by these about the picture's axes, radians.
constexpr std::array<double, 4> kRivalTurns = {-0.8, -0.45, 0.45, 0.8};
constexpr std::size_t kRivals = 3;
/// Parts of a view a side, overlapping; how many of them are proposed, and how far they are looked for, pixels.
constexpr int kPartsASide = 3;
constexpr std::size_t kPartsTried = 3;
constexpr int kPartReach = 12;
/// A candidate this near to a better one, pixels of the level and radians, is the same.
constexpr double kSamePixels = 3, kSameTurn = 0.3;

/// In steps, where three equidistant scores are highest.
double peak(double before, double here, double after) {
  const double curvature = before - 2 * here + after;
  if (curvature > -1e-6) return after > before ? 1 : -1;
  return std::clamp(0.5 * (before - after) / curvature, -1.0, 1.0);
}

}  // namespace

Pose shifted(const Pose& T_camera_object, const Eigen::Vector3d& p_object_center, const Camera& camera,
             const ShiftSearch::Result& shift) {
  const Eigen::Vector2d pixel = camera.project(T_camera_object * p_object_center) + Eigen::Vector2d(shift.dx, shift.dy);
  const Eigen::Vector3d ray((pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy, 1);
  const Eigen::Matrix3d turn =
      Keyframes::to_axis(ray).transpose() * Keyframes::to_axis(T_camera_object * p_object_center);
  return renormalized(Pose(turn) * T_camera_object);
}

Pose turned_about_center(const Pose& T_camera_object, const Extent& extent, const Eigen::Vector3d& axis, double angle) {
  return renormalized(anchored(Eigen::AngleAxisd(angle, axis) * T_camera_object.linear(), extent.p_object_center,
                               T_camera_object * extent.p_object_center));
}

Relocalizer::Relocalizer(const std::vector<Level>& levels, const Extent& extent, ShiftSearch& search,
                         ViewTemplate& view, DeviceImage& image)
    : levels_(levels),
      extent_(extent),
      search_(search),
      view_(view),
      image_(image),
      keyframes_(extent.p_object_center) {}

void Relocalizer::clear() {
  keyframes_.clear();
  last_.clear();
  searching_ = false;
}

void Relocalizer::begin(const Pose& T_last) {
  if (searching_) return;
  searching_ = true;
  T_last_ = T_last;
  keyframes_.plan(T_last);
  last_.clear();
}

Relocalizer::Levels Relocalizer::levels_for(const Pose& T_last, int finest, int most_levels) const {
  const double distance = std::max(extent_.radius, (T_last * extent_.p_object_center).norm());
  const Camera& camera = levels_[0].camera;
  const double diameter = 2 * extent_.radius * std::max(camera.fx, camera.fy) / distance;
  const auto coarsest_with = [&](double least, int from) {
    int level = from;
    while (level + 1 < most_levels && diameter / (2 << level) >= least) ++level;
    return level;
  };
  Levels result;
  result.coarsest = std::max(std::min(finest + 1, most_levels - 1), coarsest_with(kLeastSide / 0.55, finest));
  result.swept = coarsest_with(kLeastDiameter, result.coarsest);
  result.closer = std::min(result.coarsest + 1, result.swept);
  return result;
}

std::vector<PoseCandidate> Relocalizer::search(const DrawView& draw, const Levels& levels, double budget_ms) {
  const Level& searched = levels_[static_cast<std::size_t>(levels.swept)];
  search_.enqueue_gradients(image_, levels.swept);
  // Appearances are drawn on the optical axis: the centre comes to every pixel of the picture.
  const int left = static_cast<int>(std::lround(searched.camera.cx));
  const int top = static_cast<int>(std::lround(searched.camera.cy));
  const Rect shifts{-left, -top, searched.width, searched.height};
  // A third of the budget sweeps; closer looks take the next, alignments the last.
  const double view_ms = kViewCost + kShiftCost * searched.width * searched.height;
  const int sweeps = std::clamp(static_cast<int>(budget_ms / 3 / view_ms), kFewestAppearances, kMostAppearances);
  std::vector<PoseCandidate> candidates;
  for (int i = 0; i < sweeps; ++i) {
    const Pose T_appearance = keyframes_.next();
    if (!draw(T_appearance, levels.swept)) continue;
    const ShiftSearch::Result shift = search_.search(view_, image_, levels.swept, shifts, kScoredPixels);
    candidates.push_back({shifted(T_appearance, extent_.p_object_center, searched.camera, shift), shift.score});
  }
  const auto looks = static_cast<std::size_t>(std::max(2.0, budget_ms / 3 / kViewCost));
  const std::size_t turned = std::clamp<std::size_t>(looks / 36, 1, kMostCandidates);
  keep_best(candidates, std::clamp<std::size_t>(looks / 3, 4, 16), levels.swept);
  search_.enqueue_gradients(image_, levels.closer);
  for (PoseCandidate& c : candidates) c = looked_at(draw, c.T_camera_object, levels.closer, kCloserReach);
  for (const PoseCandidate& c : last_) {  // where the last frame's best are by now
    candidates.push_back(looked_at(draw, c.T_camera_object, levels.closer, kLastReach));
  }
  keep_best(candidates, turned, levels.closer);
  for (PoseCandidate& c : candidates) c = turned_to_fit(draw, c, levels.closer);
  keep_best(candidates, turned, levels.closer);
  return candidates;
}

PoseCandidate Relocalizer::looked_at(const DrawView& draw, const Pose& T_camera_object, int level, int reach) {
  if (!draw(T_camera_object, level)) return {T_camera_object, 0};
  const Camera& camera = levels_[static_cast<std::size_t>(level)].camera;
  const ShiftSearch::Result shift = search_.search(view_, image_, level, ShiftSearch::within(reach), kScoredPixels);
  return {shifted(T_camera_object, extent_.p_object_center, camera, shift), shift.score};
}

PoseCandidate Relocalizer::turned_to_fit(const DrawView& draw, const PoseCandidate& candidate, int level) {
  PoseCandidate best = candidate;
  const double last_distance = (T_last_ * extent_.p_object_center).norm();
  for (std::size_t round = 0; round < kTurns.size(); ++round) {
    const PoseCandidate here = best;
    const auto stepped = [&](const Pose& T_camera_object, int axis, double steps) {
      if (axis < 3) {
        return turned_about_center(T_camera_object, extent_, Eigen::Vector3d::Unit(axis), steps * kTurns[round]);
      }
      const Eigen::Vector3d p_center = T_camera_object * extent_.p_object_center;
      const double farther = 1 + steps * kStretches[round];
      const double distance = farther * p_center.norm() / last_distance;
      Pose result = T_camera_object;
      if (distance > kNearest && distance < kFarthest) result.translation() += (farther - 1) * p_center;
      return result;
    };
    Pose T_all = here.T_camera_object;
    for (int axis = 0; axis < 4; ++axis) {
      const PoseCandidate before = looked_at(draw, stepped(here.T_camera_object, axis, -1), level, kTurnedReach);
      const PoseCandidate after = looked_at(draw, stepped(here.T_camera_object, axis, 1), level, kTurnedReach);
      T_all = stepped(T_all, axis, peak(before.score, here.score, after.score));
      if (before.score > best.score) best = before;
      if (after.score > best.score) best = after;
    }
    const PoseCandidate all = looked_at(draw, T_all, level, kTurnedReach);
    if (all.score > best.score) best = all;
  }
  return best;
}

void Relocalizer::keep_best(std::vector<PoseCandidate>& candidates, std::size_t count, int level) const {
  std::ranges::sort(candidates, std::greater{}, &PoseCandidate::score);
  const Camera& camera = levels_[static_cast<std::size_t>(level)].camera;
  std::vector<PoseCandidate> kept;
  for (const PoseCandidate& candidate : candidates) {
    if (kept.size() == count) break;
    const auto same = [&](const PoseCandidate& other) {
      const Eigen::Vector2d apart = camera.project(candidate.T_camera_object * extent_.p_object_center) -
                                    camera.project(other.T_camera_object * extent_.p_object_center);
      return apart.norm() < kSamePixels && rotation_angle(candidate.T_camera_object.linear() *
                                                          other.T_camera_object.linear().transpose()) < kSameTurn;
    };
    if (std::none_of(kept.begin(), kept.end(), same)) kept.push_back(candidate);
  }
  candidates = std::move(kept);
}

std::vector<PoseCandidate> Relocalizer::rivals(const DrawView& draw, const Pose& T_found, int closer, int finest) {
  search_.enqueue_gradients(image_, closer);
  std::vector<PoseCandidate> candidates;
  for (int axis = 0; axis < 2; ++axis) {
    for (const double turn : kRivalTurns) {
      const Pose T_rival = turned_about_center(T_found, extent_, Eigen::Vector3d::Unit(axis), turn);
      candidates.push_back(turned_to_fit(draw, looked_at(draw, T_rival, closer, kTurnedReach), closer));
    }
  }
  keep_best(candidates, kRivals, closer);
  if (draw(T_found, finest)) {
    if (const auto T_mirrored = mirrored_tilt(view_, T_found, extent_)) candidates.push_back({*T_mirrored, 0});
  }
  return candidates;
}

std::vector<PoseCandidate> Relocalizer::search_parts(const DrawView& draw, const Pose& T_expected, int level) {
  const Rect object = view_.bounds(T_expected);
  if (object.empty() || !draw(T_expected, level)) return {};
  search_.enqueue_gradients(image_, level);
  const Camera& camera = levels_[static_cast<std::size_t>(level)].camera;
  const Rect drawn = coarser(object, level);
  const Rect shifts = ShiftSearch::within(kPartReach);
  std::vector<PoseCandidate> candidates;
  for (int row = 0; row < kPartsASide; ++row) {
    for (int column = 0; column < kPartsASide; ++column) {
      // Half as wide and high as the view, each half over the next.
      const Rect part{drawn.x + column * drawn.width / (kPartsASide + 1),
                      drawn.y + row * drawn.height / (kPartsASide + 1), 2 * drawn.width / (kPartsASide + 1),
                      2 * drawn.height / (kPartsASide + 1)};
      const ShiftSearch::Result shift = search_.search(view_, image_, level, shifts, kScoredPixels, part);
      candidates.push_back({shifted(T_expected, extent_.p_object_center, camera, shift), shift.score});
    }
  }
  std::ranges::sort(candidates, std::greater{}, &PoseCandidate::score);
  candidates.resize(std::min(candidates.size(), kPartsTried));
  return candidates;
}

}  // namespace holdfast
