#include "recovery/outline_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "base/turns.hpp"
#include "contour/contour_points.hpp"
#include "edges/visible_edges.hpp"

namespace holdfast {
namespace {

/// Widest level that is looked at, pixels, and the object's least radius on it.
constexpr int kWidest = 160;
constexpr double kLeastRadius = 12;
/// Radians between views and between their turns about the optical axis, of which those of other remembered sides have
/// fewer.
constexpr double kSwing = 0.3, kTwist = 0.22, kRememberedTwist = 0.44;
/// The same of all sides, and the frame of a search from which on these are looked at in every second one.
constexpr double kSideSwing = 0.4, kSideTwist = 0.3;
constexpr int kAllSidesFrom = 15;
/// How near or far it may have gone meanwhile.
constexpr std::array<double, 4> kDistances = {0.84, 0.95, 1.06, 1.19};
/// Points of a view, evenly taken, and pixels beside the contour's that are looked at.
constexpr std::size_t kMostPoints = 96, kLeastPoints = 16;
constexpr int kReach = 2;
/// Nominal milliseconds of reading a frame and of a template, and templates that are compared with a frame anyhow.
constexpr double kFrameMs = 6, kTemplateMs = 0.02;
constexpr std::size_t kLeastTemplates = 100;
/// They are compared by one of so many of their points, and the best, one of so many, by all.
constexpr std::size_t kEach = 3, kLookedAt = 8;
/// Views drawn in a frame.
constexpr int kMostViews = 12;
/// Each so many-th point of these moves the pose to where more agree: first steps, radians or pixels of the level, of
/// which each next is half, and how often each is gone through at most.
constexpr std::size_t kEachRefined = 2;
constexpr double kFirstTurn = 0.12, kFirstShift = 2;
constexpr int kSteps = 3, kRounds = 4;
/// Starts that are proposed, and how far apart they are, object radii or radians.
constexpr std::size_t kMostStarts = 3;
constexpr double kApart = 0.5, kTurnedApart = 0.3;

}  // namespace

OutlineSearch::OutlineSearch(const Device::Impl& device, const std::vector<Level>& levels, const Extent& extent,
                             const std::vector<EdgeSample>& samples, DeviceImage& image, DepthView& shape)
    : device_(device),
      levels_(levels),
      extent_(extent),
      samples_(samples),
      image_(image),
      shape_(shape),
      keyframes_(extent.p_object_center) {}

void OutlineSearch::clear() {
  keyframes_.clear();
  searching_ = false;
}

void OutlineSearch::Plan::add(const Pose& T_view, double swing, int twists, double step) {
  views.push_back({T_view, {}, false});
  for (int i = -twists; i <= twists; ++i) {
    for (const double distance : kDistances) {
      const double twist = i * step;
      templates.push_back({views.size() - 1, twist, distance, std::hypot(swing, twist)});
    }
  }
}

void OutlineSearch::plan(const Pose& T_last) {
  const Eigen::Vector3d p_last = T_last * extent_.p_object_center;
  const double radius = levels_[0].camera.fx * extent_.radius / std::max(p_last.z(), 1e-6);
  level_ = 0;
  while (static_cast<std::size_t>(level_) + 1 < levels_.size() &&
         levels_[static_cast<std::size_t>(level_)].width > kWidest && radius / (2 << level_) >= kLeastRadius) {
    ++level_;
  }
  around_ = all_sides_ = {};
  const Eigen::Vector3d p_center(0, 0, p_last.norm());
  constexpr double kMostTurn = Keyframes::kMostTurn;
  const auto on_axis = [&](const Eigen::Matrix3d& R_camera_object) {
    return anchored(R_camera_object, extent_.p_object_center, p_center);
  };
  const Eigen::Matrix3d R_last = Keyframes::to_axis(p_last) * T_last.linear();
  const int reach = static_cast<int>(kMostTurn / kSwing) + 1;
  for (int i = -reach; i <= reach; ++i) {  // a triangular lattice of turns that bring other sides to the front
    for (int j = -reach; j <= reach; ++j) {
      const Eigen::Vector3d swing(kSwing * (i + 0.5 * j), kSwing * std::sqrt(0.75) * j, 0);
      const double angle = swing.norm();
      if (angle > kMostTurn) continue;
      around_.add(on_axis(Eigen::AngleAxisd(angle, swing.normalized()) * R_last), angle,
                  static_cast<int>(kMostTurn / kTwist), kTwist);
    }
  }
  const std::vector<View>& views = around_.views;
  const auto around = static_cast<std::ptrdiff_t>(views.size());
  for (const Pose& T : keyframes_.remembered()) {
    const auto near = [&](const View& view) { return turn_between(view.T_camera_object, T) < Keyframes::kElsewhere; };
    if (std::any_of(views.begin(), views.begin() + around, near)) continue;
    around_.add(on_axis(T.linear()), kMostTurn, static_cast<int>(kRememberedTwist / kTwist), kTwist);
  }
  std::ranges::stable_sort(around_.templates, {}, &Template::turn);
  // A spiral over the sphere passes all sides evenly, the nearest first.
  const int sides = static_cast<int>(4 * std::numbers::pi / (std::sqrt(0.75) * kSideSwing * kSideSwing));
  for (int i = 0; i < sides; ++i) {
    const double swing = std::acos(1 - (2 * i + 1.0) / sides), along = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const Eigen::Vector3d axis(-std::sin(along), std::cos(along), 0);
    all_sides_.add(on_axis(Eigen::AngleAxisd(swing, axis) * R_last), swing,
                   static_cast<int>(std::numbers::pi / kSideTwist), kSideTwist);
  }
}

void OutlineSearch::draw(View& view) {
  view.drawn = true;
  if (!shape_.draw(view.T_camera_object, level_, 0)) return;
  const Camera& camera = levels_[static_cast<std::size_t>(level_)].camera;
  const Eigen::Vector2f center = camera.project(view.T_camera_object * extent_.p_object_center).cast<float>();
  std::vector<OutlinePoint> points;
  std::vector<ContourPoint> contour;
  ContourScan scan;
  contour_points(shape_.drawn(), camera, kMostPoints, kReach, scan, contour);
  for (const ContourPoint& point : contour) {
    const Eigen::Vector2f at = camera.project(point.p_camera.cast<double>()).cast<float>() - center;
    points.push_back({at.x(), at.y(), std::atan2(point.normal.y(), point.normal.x()), true, point.p_camera});
  }
  std::vector<VisibleEdge> edges;
  visible_edges(samples_, shape_.T_drawn(), camera, shape_.drawn(), kBehind * extent_.radius, kMostPoints, edges);
  for (const VisibleEdge& edge : edges) {
    if (edge.outward != 0) continue;  // the contour has it
    const Eigen::Vector2f at = edge.pixel.cast<float>() - center, normal = edge.normal.cast<float>();
    points.push_back({at.x(), at.y(), std::atan2(normal.y(), normal.x()), false, edge.p_camera.cast<float>()});
  }
  const std::size_t count = std::min(points.size(), kMostPoints);
  for (std::size_t i = 0; i < count; ++i) view.points.push_back(points[i * points.size() / count]);
}

void OutlineSearch::read_frame(const ColorHistograms& colors) {
  const Level& level = levels_[static_cast<std::size_t>(level_)];
  image_.enqueue_pixels(level_);
  pixels_.resize(4 * level.elements);
  device_.queue.enqueueReadBuffer(image_.pixels(level_), CL_TRUE, 0, pixels_.size() * sizeof(float), pixels_.data());
  says_.assign(static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height), 0.0F);
  const float* first = pixels_.data() + 4 * level.layout.origin;
  auto out = says_.begin();
  for (int y = 0; y < level.height && colors.known(); ++y) {
    for (int x = 0; x < level.width; ++x) {
      const float* pixel = first + 4 * (static_cast<std::ptrdiff_t>(y) * level.layout.stride + x);
      *out++ = 2 * colors.share()[static_cast<std::size_t>(color_bin(pixel))] - 1;
    }
  }
  double most = 0;
  for (const View& view : tried_->views) {
    for (const OutlinePoint& point : view.points) most = std::max(most, std::hypot(double(point.x), double(point.y)));
  }
  const int margin = static_cast<int>(most / kDistances.front()) + 2;
  responses_.compute(first, level.layout.stride, says_, level.width, level.height, margin);
}

OutlineSearch::Peak OutlineSearch::best_place(const Template& shown, std::size_t each) {
  constexpr int kStep = DirectionResponses::kStep;
  const Level& level = levels_[static_cast<std::size_t>(level_)];
  const int columns = (level.width + kStep - 1) / kStep, rows = (level.height + kStep - 1) / kStep;
  const int stride = responses_.columns(), margin = responses_.margin();
  const auto size = static_cast<std::size_t>((rows - 1) * stride + columns);
  sums_.assign(size, 0);
  const double c = std::cos(shown.twist) / shown.distance, s = std::sin(shown.twist) / shown.distance;
  const std::vector<OutlinePoint>& points = tried_->views[shown.view].points;
  double used = 0;
  for (std::size_t n = 0; n < points.size(); n += each) {
    const OutlinePoint& point = points[n];
    used += 1;
    const double px = static_cast<double>(point.x), py = static_cast<double>(point.y);
    const int x = margin + static_cast<int>(std::lround(c * px - s * py));
    const int y = margin + static_cast<int>(std::lround(s * px + c * py));
    const double normal = static_cast<double>(point.normal) + shown.twist;
    const int direction = DirectionResponses::direction(std::cos(normal), std::sin(normal));
    const std::uint8_t* from = point.contour ? responses_.contours(direction, x, y)
                                             : responses_.edges(direction % DirectionResponses::kEdges, x, y);
    std::uint16_t* to = sums_.data();
    for (std::size_t i = 0; i < size; ++i) to[i] = static_cast<std::uint16_t>(to[i] + from[i]);
  }
  std::uint16_t best = 0;
  Peak peak;
  peak.shown = shown;
  for (int row = 0; row < rows; ++row) {
    const std::uint16_t* here = sums_.data() + static_cast<std::ptrdiff_t>(row) * stride;
    const std::uint16_t* top = std::max_element(here, here + columns);
    if (*top <= best) continue;
    best = *top;
    peak.place = kStep * Eigen::Vector2d(static_cast<double>(top - here), row);
  }
  peak.score = best / used;
  return peak;
}

Pose OutlineSearch::pose_at(const Peak& peak) const {
  const Camera& camera = levels_[static_cast<std::size_t>(level_)].camera;
  const View& view = tried_->views[peak.shown.view];
  Pose T = view.T_camera_object;
  const Eigen::Vector3d p_center = T * extent_.p_object_center;
  T.translation() += (peak.shown.distance - 1) * p_center;
  const Eigen::Vector3d ray((peak.place.x() - camera.cx) / camera.fx, (peak.place.y() - camera.cy) / camera.fy, 1);
  const Eigen::Matrix3d R = Keyframes::to_axis(ray).transpose() *
                            Eigen::AngleAxisd(peak.shown.twist, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  return renormalized(Pose(R) * T);
}

double OutlineSearch::agreement(const View& view, const Pose& T_camera_object) const {
  const Camera& camera = levels_[static_cast<std::size_t>(level_)].camera;
  const Pose D = T_camera_object * view.T_camera_object.inverse();
  const double twist = std::atan2(D(1, 0) - D(0, 1), D(0, 0) + D(1, 1));
  const double turns = (twist / (2 * std::numbers::pi) + 2) * DirectionResponses::kContours + 0.5;
  const int margin = responses_.margin();
  const int width = responses_.columns() * DirectionResponses::kStep,
            height = responses_.rows() * DirectionResponses::kStep;
  double sum = 0, used = 0;
  for (std::size_t n = 0; n < view.points.size(); n += kEachRefined) {
    const OutlinePoint& point = view.points[n];
    const Eigen::Vector3d p = D * point.p_camera.cast<double>();
    used += 1;
    const int x = margin + static_cast<int>(std::lround(camera.fx * p.x() / p.z() + camera.cx));
    const int y = margin + static_cast<int>(std::lround(camera.fy * p.y() / p.z() + camera.cy));
    if (p.z() <= 0 || x < 0 || y < 0 || x >= width || y >= height) {
      sum += DirectionResponses::kNothing;
      continue;
    }
    const int direction = static_cast<int>(turns + static_cast<double>(point.normal) * DirectionResponses::kContours /
                                                       (2 * std::numbers::pi)) %
                          DirectionResponses::kContours;
    sum += point.contour ? *responses_.contours(direction, x, y)
                         : *responses_.edges(direction % DirectionResponses::kEdges, x, y);
  }
  return sum / std::max(1.0, used);
}

PoseCandidate OutlineSearch::refined(const Peak& peak) const {
  const View& view = tried_->views[peak.shown.view];
  const Camera& camera = levels_[static_cast<std::size_t>(level_)].camera;
  PoseCandidate best;
  best.T_camera_object = pose_at(peak);
  best.score = agreement(view, best.T_camera_object);
  for (int step = 0; step < kSteps; ++step) {
    const double turn = kFirstTurn / (1 << step), shift = kFirstShift / (1 << step);
    bool moved = true;
    for (int round = 0; round < kRounds && moved; ++round) {
      moved = false;
      for (int motion = 0; motion < 12; ++motion) {
        const double side = motion % 2 == 0 ? 1 : -1;
        Pose T = best.T_camera_object;
        const Eigen::Vector3d p_center = T * extent_.p_object_center;
        if (motion < 6) {
          T = turned_about_center(T, extent_, Eigen::Vector3d::Unit(motion / 2), side * turn);
        } else if (motion < 10) {
          T.translation()(motion / 2 - 3) += side * shift * p_center.z() / camera.fx;
        } else {
          T.translation() += side * turn / 2 * p_center;
        }
        const double score = agreement(view, T);
        if (score <= best.score) continue;
        best = {T, score};
        moved = true;
      }
    }
  }
  return best;
}

std::vector<Pose> OutlineSearch::starts(const Pose& T_last, const ColorHistograms& colors, double budget_ms,
                                        bool all_sides) {
  if (!searching_) plan(T_last);
  frames_ = searching_ ? frames_ + 1 : 0;
  searching_ = true;
  tried_ = all_sides && frames_ >= kAllSidesFrom && frames_ % 2 == 1 ? &all_sides_ : &around_;
  std::vector<Template>& templates = tried_->templates;
  std::vector<const Template*> part;
  int drawn = 0;
  const auto affordable = static_cast<std::size_t>(std::max(0.0, budget_ms - kFrameMs) / kTemplateMs);
  for (std::size_t i = 0; i < std::min(std::max(kLeastTemplates, affordable), templates.size()); ++i) {
    const Template& shown = templates[tried_->next];
    View& view = tried_->views[shown.view];
    if (!view.drawn) {
      if (drawn++ == kMostViews) break;
      draw(view);
    }
    tried_->next = (tried_->next + 1) % templates.size();
    if (view.points.size() >= kLeastPoints) part.push_back(&shown);
  }
  read_frame(colors);
  std::vector<Peak> peaks;
  for (const Template* shown : part) peaks.push_back(best_place(*shown, kEach));
  std::ranges::stable_sort(peaks, std::greater{}, &Peak::score);
  peaks.resize((peaks.size() + kLookedAt - 1) / kLookedAt);
  for (Peak& peak : peaks) peak = best_place(peak.shown, 1);
  std::vector<PoseCandidate> found;
  for (const Peak& peak : peaks) found.push_back(refined(peak));
  std::ranges::stable_sort(found, std::greater{}, &PoseCandidate::score);
  std::vector<Pose> poses;
  for (const PoseCandidate& near : found) {
    const Pose& T = near.T_camera_object;
    const auto same = [&](const Pose& other) {
      return turn_between(T, other) < kTurnedApart &&
             ((T * extent_.p_object_center) - (other * extent_.p_object_center)).norm() < kApart * extent_.radius;
    };
    if (std::any_of(poses.begin(), poses.end(), same)) continue;
    poses.push_back(T);
    if (poses.size() == kMostStarts) break;
  }
  return poses;
}

}  // namespace holdfast
