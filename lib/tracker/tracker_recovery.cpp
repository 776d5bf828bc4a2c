#include <algorithm>
#include <cmath>
#include <utility>

#include "base/stopwatch.hpp"
#include "tracker/tracker_impl.hpp"

namespace holdfast {
namespace {

/// Least diameter of the object on the level that the whole picture is searched on, pixels: coarser is cheaper, and
/// appearances may be farther apart.
constexpr double kLeastDiameter = 10;
/// Pixels of the view that a place is scored with, about.
constexpr double kScoredPixels = 200;
/// Places that are looked at closer.
constexpr std::size_t kPlacesLookedAt = 16;
/// What a place is turned by, radians, and brought nearer or farther by, as a share, in each round.
constexpr std::array<double, 2> kTurns = {0.2, 0.1}, kStretches = {0.1, 0.05};
/// Distances that it is believed at, as shares of the last one: too far away, anything looks like it.
constexpr double kNearest = 0.6, kFarthest = 1.7;
/// Pixels that a closer look may move a place by, and one from the last frame.
constexpr int kCloserReach = 4, kTurnedReach = 2, kLastReach = 10;
/// What is found is compared with itself turned by these about the picture's axes, radians, so many of which go through
/// all stages; and with its mirror image.
constexpr std::array<double, 4> kRivalTurns = {-0.8, -0.45, 0.45, 0.8};
constexpr std::size_t kRivals = 3;
/// Parts of a view a side, overlapping; how many of them are begun with, and how far they are looked for, pixels of the
/// level.
constexpr int kPartsASide = 3;
constexpr std::size_t kPartsTried = 3;
constexpr int kPartReach = 12;
/// Tilted by less than this, radians, it is nearly its own mirror image.
constexpr double kLeastTilt = 0.05;
/// Views that a start is looked at in on coarse levels, at most.
constexpr int kMostCoarseStages = 3;
/// A place this near to a better one, pixels of the level and radians, is the same.
constexpr double kSamePlacePixels = 3, kSamePlaceTurn = 0.3;
/// Share of the usual coarse score below which a start is not worth a finer level.
constexpr double kHopelessScore = 0.1;

/// In steps, where three equidistant scores are highest.
double peak(double before, double here, double after) {
  const double curvature = before - 2 * here + after;
  if (curvature > -1e-6) return after > before ? 1 : -1;
  return std::clamp(0.5 * (before - after) / curvature, -1.0, 1.0);
}

/// Turned about the camera, so that it looks the same elsewhere: its centre comes to this pixel.
Pose brought_to(const Pose& T_camera_object, const Eigen::Vector3d& p_object_center, const Camera& camera,
                const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d ray((pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy, 1);
  const Eigen::Matrix3d turn =
      Keyframes::to_axis(ray).transpose() * Keyframes::to_axis(T_camera_object * p_object_center);
  return renormalized(Pose(turn) * T_camera_object);
}

/// The same, moved as its view was shifted on a level.
Pose shifted(const Pose& T_camera_object, const Eigen::Vector3d& p_object_center, const Camera& camera,
             const ShiftSearch::Result& shift) {
  const Eigen::Vector2d pixel = camera.project(T_camera_object * p_object_center) + Eigen::Vector2d(shift.dx, shift.dy);
  return brought_to(T_camera_object, p_object_center, camera, pixel);
}

}  // namespace

double Tracker::Impl::diameter_pixels() const {
  const double distance = std::max(radius_, (motion_.pose() * p_object_center_).norm());
  return 2 * radius_ * std::max(camera_.fx, camera_.fy) / distance;
}

void Tracker::Impl::sweep(int level, std::vector<Place>& places) {
  const Level& searched = levels_[static_cast<std::size_t>(level)];
  const Camera& camera = searched.camera;
  search_.enqueue_gradients(image_, level);
  // Appearances are drawn on the optical axis: the centre comes to every pixel of the picture.
  const int left = static_cast<int>(std::lround(camera.cx)), top = static_cast<int>(std::lround(camera.cy));
  const Rect shifts{-left, -top, searched.width, searched.height};
  for (int i = 0; i < kAppearancesAFrame; ++i) {
    const Pose T_appearance = keyframes_.next();
    if (!draw(T_appearance, level, 1)) continue;
    const Stopwatch watch(times_.search);
    const ShiftSearch::Result shift = search_.search(view_, image_, level, shifts, kScoredPixels);
    places.push_back({shifted(T_appearance, p_object_center_, camera, shift), shift.score});
  }
}

Tracker::Impl::Place Tracker::Impl::looked_at(const Pose& T_camera_object, int level, int reach) {
  if (!draw(T_camera_object, level, 1)) return {T_camera_object, 0};
  const Stopwatch watch(times_.search);
  const Camera& camera = levels_[static_cast<std::size_t>(level)].camera;
  const Rect shifts{-reach, -reach, 2 * reach + 1, 2 * reach + 1};
  const ShiftSearch::Result shift = search_.search(view_, image_, level, shifts, kScoredPixels);
  return {shifted(T_camera_object, p_object_center_, camera, shift), shift.score};
}

Tracker::Impl::Place Tracker::Impl::turned_to_fit(const Place& place, int level) {
  Place best = place;
  const double last_distance = (motion_.pose() * p_object_center_).norm();
  for (std::size_t round = 0; round < kTurns.size(); ++round) {
    const Place here = best;
    const auto stepped = [&](const Pose& T_camera_object, int axis, double steps) {
      if (axis < 3) return turned(T_camera_object, Eigen::Vector3d::Unit(axis), steps * kTurns[round]);
      const Eigen::Vector3d p_center = T_camera_object * p_object_center_;
      const double farther = 1 + steps * kStretches[round];
      const double distance = farther * p_center.norm() / last_distance;
      Pose result = T_camera_object;
      if (distance > kNearest && distance < kFarthest) result.translation() += (farther - 1) * p_center;
      return result;
    };
    Pose T_all = here.T_camera_object;
    for (int axis = 0; axis < 4; ++axis) {
      const Place before = looked_at(stepped(here.T_camera_object, axis, -1), level, kTurnedReach);
      const Place after = looked_at(stepped(here.T_camera_object, axis, 1), level, kTurnedReach);
      T_all = stepped(T_all, axis, peak(before.score, here.score, after.score));
      if (before.score > best.score) best = before;
      if (after.score > best.score) best = after;
    }
    const Place all = looked_at(T_all, level, kTurnedReach);
    if (all.score > best.score) best = all;
  }
  return best;
}

void Tracker::Impl::keep_best(std::vector<Place>& places, std::size_t count, int level) const {
  std::sort(places.begin(), places.end(), [](const Place& a, const Place& b) { return a.score > b.score; });
  const Camera& camera = levels_[static_cast<std::size_t>(level)].camera;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < places.size() && kept < count; ++i) {
    const Place place = places[i];
    const auto same = [&](const Place& other) {
      const Eigen::Vector2d apart = camera.project(place.T_camera_object * p_object_center_) -
                                    camera.project(other.T_camera_object * p_object_center_);
      return apart.norm() < kSamePlacePixels &&
             rotation_angle(place.T_camera_object.linear() * other.T_camera_object.linear().transpose()) <
                 kSamePlaceTurn;
    };
    const auto end = places.begin() + static_cast<std::ptrdiff_t>(kept);
    if (std::none_of(places.begin(), end, same)) places[kept++] = place;
  }
  places.resize(std::min(kept, places.size()));
}

Estimate Tracker::Impl::coarsely_settled(const Pose& T_start, int coarsest, int finest) {
  // From so far away once is not enough.
  Estimate estimate = coarse_stage(T_start, true, coarsest, finest);
  for (int i = 1; i < kMostCoarseStages && estimate.solved && estimate.score < look_.usual_score; ++i) {
    const Estimate again = coarse_stage(estimate.T_camera_object, true, coarsest, finest);
    if (again.score <= estimate.score) break;
    estimate = again;
  }
  return estimate;
}

std::optional<Pose> Tracker::Impl::mirrored(const Pose& T_camera_object) {
  if (!draw(T_camera_object, finest_, 1)) return {};
  const std::optional<Eigen::Vector3d> normal = view_.mean_normal();
  if (!normal) return {};
  const Eigen::Vector3d to_camera = -(T_camera_object * p_object_center_).normalized();
  const Eigen::Vector3d axis = normal->cross(to_camera);
  const double tilt = std::atan2(axis.norm(), normal->dot(to_camera));
  if (tilt < kLeastTilt) return {};
  return turned(T_camera_object, axis.normalized(), 2 * tilt);
}

Estimate Tracker::Impl::best_of_rivals(const Estimate& found, int closer, int coarsest, int coarse_finest) {
  Estimate best = found;
  const double surviving_share = std::exchange(look_.surviving_share, 0.0);
  const bool moved = std::exchange(moved_, false);
  search_.enqueue_gradients(image_, closer);
  places_.clear();
  for (int axis = 0; axis < 2; ++axis) {
    for (const double turn : kRivalTurns) {
      const Pose T_rival = turned(found.T_camera_object, Eigen::Vector3d::Unit(axis), turn);
      places_.push_back(turned_to_fit(looked_at(T_rival, closer, kTurnedReach), closer));
    }
  }
  keep_best(places_, kRivals, closer);
  look_.surviving_share = surviving_share;
  moved_ = moved;
  if (const std::optional<Pose> T_mirrored = mirrored(found.T_camera_object)) places_.push_back({*T_mirrored, 0});
  search_.enqueue_gradients(image_, coarsest);
  for (const Place& place : places_) {
    const Estimate start = coarsely_settled(place.T_camera_object, coarsest, coarse_finest);
    if (start.score < kHopelessScore * look_.usual_score) continue;
    const Estimate rival = settled(fine_stage(start.T_camera_object, std::max(coarse_finest - 1, finest_), -1));
    if (rival.score > best.score) best = rival;
  }
  return best;
}

Estimate Tracker::Impl::found_in_parts(const Pose& T_expected) {
  Estimate best;
  best.T_camera_object = T_expected;
  const int level = std::min(finest_ + 1, options_.levels - 1);
  const Camera& camera = levels_[static_cast<std::size_t>(level)].camera;
  const Rect object = view_.bounds(T_expected);
  if (object.empty()) return best;
  {
    const Stopwatch watch(times_.filter);
    image_.enqueue_blur(level, coarser(grown(object, (kPartReach + filter_.radius() + 4) << level), level));
    search_.enqueue_gradients(image_, level);
  }
  const bool expected = std::exchange(expected_, false);
  parts_.clear();
  if (draw(T_expected, level, 1)) {
    const Stopwatch watch(times_.search);
    const Rect drawn = coarser(object, level);
    const Rect shifts{-kPartReach, -kPartReach, 2 * kPartReach + 1, 2 * kPartReach + 1};
    for (int row = 0; row < kPartsASide; ++row) {
      for (int column = 0; column < kPartsASide; ++column) {
        // Half as wide and high as the view, each half over the next.
        const Rect part{drawn.x + column * drawn.width / (kPartsASide + 1),
                        drawn.y + row * drawn.height / (kPartsASide + 1), 2 * drawn.width / (kPartsASide + 1),
                        2 * drawn.height / (kPartsASide + 1)};
        parts_.push_back(search_.search(view_, image_, level, shifts, kScoredPixels, part));
      }
    }
  }
  std::sort(parts_.begin(), parts_.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
  for (std::size_t i = 0; i < std::min(kPartsTried, parts_.size()) && !is_good(best); ++i) {
    const Estimate estimate = fine_stage(shifted(T_expected, p_object_center_, camera, parts_[i]), level, -1);
    if (estimate.score > best.score) best = estimate;
  }
  expected_ = expected;
  return best;
}

Estimate Tracker::Impl::found_anywhere(const Rect& region) {
  Estimate best;
  best.T_camera_object = motion_.pose();
  const double diameter = diameter_pixels();
  const auto coarsest_with = [&](double least, int from) {
    int level = from;
    while (level + 1 < options_.levels && diameter / (2 << level) >= least) ++level;
    return level;
  };
  const int finest = finest_;
  const int coarsest = std::max(std::min(finest + 1, options_.levels - 1), coarsest_with(kLeastSide / 0.55, finest));
  const int swept = coarsest_with(kLeastDiameter, coarsest);
  const int closer = std::min(coarsest + 1, swept);
  const int coarse_finest = std::max(coarsest - 1, finest);
  {
    const Stopwatch watch(times_.filter);
    for (int level = coarse_finest; level <= swept; ++level) image_.enqueue_blur(level, coarser(region, level));
  }
  // So coarse, the margin would leave nothing of most objects; what the silhouette adds is as good a sign as texture.
  const double surviving_share = std::exchange(look_.surviving_share, 0.0);
  // Nothing is known of its motion either.
  const bool moved = std::exchange(moved_, false);
  const bool expected = std::exchange(expected_, false);
  places_.clear();
  sweep(swept, places_);
  keep_best(places_, kPlacesLookedAt, swept);
  search_.enqueue_gradients(image_, closer);
  for (Place& place : places_) place = looked_at(place.T_camera_object, closer, kCloserReach);
  // Where the last frame's best places are by now.
  for (const Place& place : last_places_) places_.push_back(looked_at(place.T_camera_object, closer, kLastReach));
  keep_best(places_, kMostPlaces, closer);
  for (Place& place : places_) place = turned_to_fit(place, closer);
  keep_best(places_, kMostPlaces, closer);
  look_.surviving_share = surviving_share;
  moved_ = moved;

  search_.enqueue_gradients(image_, coarsest);
  last_places_.clear();
  std::array<Estimate, kMostPlaces> starts;
  std::size_t count = 0;
  for (const Place& place : places_) {
    const Estimate start = coarsely_settled(place.T_camera_object, coarsest, coarse_finest);
    if (start.score >= kHopelessScore * look_.usual_score) {
      std::size_t rank = count++;
      for (; rank > 0 && starts[rank - 1].score < start.score; --rank) starts[rank] = starts[rank - 1];
      starts[rank] = start;
      last_places_.push_back({start.T_camera_object, start.score});
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    const Estimate estimate = fine_stage(starts[i].T_camera_object, std::max(coarse_finest - 1, finest), -1);
    if (estimate.score > best.score) best = estimate;
    if (is_good(best)) break;
  }
  if (is_probable(best)) best = best_of_rivals(best, closer, coarsest, coarse_finest);
  expected_ = expected;
  return best;
}

}  // namespace holdfast
