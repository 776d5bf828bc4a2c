#include "simulation/motion.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include "holdfast/error.hpp"
#include "simulation/random.hpp"

namespace holdfast::simulation {
namespace {

using Corners = std::array<Eigen::Vector3d, 8>;

// Where an object is and how it is turned, in numbers that always put it into view.
struct Placement {
  double across = 0;                               // -1: as far left as the object fits, 1: as far right
  double down = 0;                                 // -1: as high as it fits, 1: as low
  double distance = 0;                             // -1: nearest, 1: farthest
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();  // rotation vector away from the middle orientation, camera axes
};

Pose between(const Pose& from, const Pose& to, double share) {
  Pose pose = Pose::Identity();
  const Eigen::Quaterniond turn(from.linear()), end(to.linear());
  pose.linear() = turn.slerp(share, end).normalized().toRotationMatrix();
  pose.translation() = from.translation() + share * (to.translation() - from.translation());
  return pose;
}

class Stage {
 public:
  Stage(const MotionOptions& options, const Mesh& mesh, const Camera& camera)
      : camera_(camera), corners_(bounding_corners(mesh)), options_(options) {
    center_ = 0.5 * (corners_.front() + corners_.back());
    half_size_ = corners_.back() - center_;
    const double radius = half_size_.norm();
    if (options_.nearest <= 0) {
      options_.nearest =
          std::max(2.0 * radius, 2.4 * radius * std::max(camera.fx / camera.width, camera.fy / camera.height));
    }
    if (options_.farthest <= 0) options_.farthest = 2.0 * options_.nearest;
    if (options_.nearest <= radius) {
      throw Error(ErrorCode::invalid_argument,
                  "motion: the nearest distance is within the object's radius; move it farther away");
    }
    if (options_.farthest < options_.nearest) {
      throw Error(ErrorCode::invalid_argument, "motion: the farthest distance is below the nearest; swap them");
    }
  }

  Pose pose(const Placement& p) const {
    const double angle = p.turn.norm();
    Pose pose = Pose::Identity();
    pose.linear() = options_.orientation;
    if (angle > 0) pose.linear() = Eigen::AngleAxisd(angle, p.turn / angle) * options_.orientation;
    const double z = options_.nearest * std::pow(options_.farthest / options_.nearest, 0.5 * (1.0 + p.distance));
    // Half the extent of the turned bounding box along the camera's axes; rounded at zero so that motion stays smooth.
    Eigen::Vector3d half;
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d reach = pose.linear().row(axis).transpose().cwiseProduct(half_size_);
      half[axis] = (reach.array().square() + std::pow(0.02 * half_size_.norm(), 2)).sqrt().sum();
    }
    const double front = std::max(z - half.z(), 0.1 * z);
    const auto place = [&](double share, double size, double focal, double center, double extent) {
      // Image positions of the centre at which the box's front still ends within the margin.
      const double low = ((options_.margin - center) * front + focal * extent) / z;
      const double high = ((size - 1 - options_.margin - center) * front - focal * extent) / z;
      const double room = 0.5 * (high - low);
      const double soft = 0.02 * size;  // where the object does not fit it stays near the middle
      return (0.5 * (high + low) + share * 0.5 * (room + std::hypot(room, soft))) / focal * z;
    };
    const Eigen::Vector3d center_camera(place(p.across, camera_.width, camera_.fx, camera_.cx, half.x()),
                                        place(p.down, camera_.height, camera_.fy, camera_.cy, half.y()), z);
    pose.translation() = center_camera - pose.linear() * center_;
    return pose;
  }

  double motion(const Pose& a, const Pose& b) const { return corner_motion(corners_, camera_, a, b); }

  // Image motion of all corners in pixels, as one vector.
  Eigen::Matrix<double, 16, 1> flow(const Pose& a, const Pose& b) const {
    Eigen::Matrix<double, 16, 1> result;
    for (int i = 0; i < 8; ++i) {
      result.segment<2>(2 * i) =
          pixel(b * corners_[static_cast<std::size_t>(i)]) - pixel(a * corners_[static_cast<std::size_t>(i)]);
    }
    return result;
  }

  bool in_view(const Pose& pose) const {
    const Eigen::Vector2d center = pixel(pose * center_);
    int outside = 0;
    for (const Eigen::Vector3d& corner : corners_) {
      const Eigen::Vector2d p = pixel(pose * corner);
      if (p.x() < 0 || p.y() < 0 || p.x() > camera_.width - 1 || p.y() > camera_.height - 1) ++outside;
    }
    const double slack_x = 0.25 * camera_.width, slack_y = 0.25 * camera_.height;
    return outside <= 2 && center.x() > slack_x && center.x() < camera_.width - slack_x && center.y() > slack_y &&
           center.y() < camera_.height - slack_y;
  }

  bool is_view_of(const Pose& pose) const {
    for (const Eigen::Vector3d& corner : corners_) {
      if ((pose * corner).z() < 1e-3) return false;
    }
    return true;
  }

  Eigen::Vector3d center_camera(const Pose& pose) const { return pose * center_; }

 private:
  Eigen::Vector2d pixel(const Eigen::Vector3d& p) const {
    return {camera_.fx * p.x() / p.z() + camera_.cx, camera_.fy * p.y() / p.z() + camera_.cy};
  }

  Camera camera_;
  Corners corners_;
  MotionOptions options_;
  Eigen::Vector3d center_;
  Eigen::Vector3d half_size_;
};

// A number in [-1, 1] that varies as a sum of three sines.
struct Wave {
  std::array<double, 3> strength, frequency, phase;

  explicit Wave(Random& random) {
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      strength[i] = random.uniform(0.4, 1.0);
      frequency[i] = random.uniform(0.5, 2.0);
      phase[i] = random.uniform(0.0, 2.0 * std::numbers::pi);
      sum += strength[i];
    }
    for (double& s : strength) s /= sum;
  }
  double at(double time) const {
    double value = 0;
    for (std::size_t i = 0; i < 3; ++i) value += strength[i] * std::sin(frequency[i] * time + phase[i]);
    return value;
  }
};

PoseAt smooth_motion(const Stage& stage, const MotionOptions& options, int frames, std::uint64_t seed) {
  Random random(seed, 0x51e5);
  std::vector<Wave> waves;
  for (int i = 0; i < 6; ++i) waves.emplace_back(random);
  const auto at = [stage, waves, range = options.rotation_range](double time) {
    Placement p{waves[0].at(time), waves[1].at(time), waves[2].at(time), {}};
    // Each axis' sum of sines seldom comes near 1: stretched so that the range is used, never left.
    for (int k = 0; k < 3; ++k)
      p.turn[k] = range * std::sin(0.5 * std::numbers::pi * waves[static_cast<std::size_t>(3 + k)].at(time));
    return stage.pose(p);
  };
  // The slower the sines run, the slower the corners: find the pace at which 95 % of the frames keep to the speed.
  const auto speed_at = [&](double pace) {
    std::vector<double> speeds;
    Pose last = at(0);
    for (int i = 1; i < std::max(frames, 2); ++i) {
      const Pose next = at(pace * i);
      speeds.push_back(stage.motion(last, next));
      last = next;
    }
    const auto nth = speeds.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(speeds.size() - 1));
    std::nth_element(speeds.begin(), nth, speeds.end());
    return *nth;
  };
  double low = 0, high = 1e-4;
  constexpr double fastest_pace = 0.4;  // radians a frame: beyond, the motion is a jitter and no longer smooth
  while (speed_at(high) < options.speed) {
    low = high;
    high *= 1.25;
    if (high > fastest_pace) {
      throw Error(
          ErrorCode::invalid_argument,
          "motion: the object cannot move that fast smoothly and stay in view; lower the speed, bring it nearer or "
          "allow more rotation");
    }
  }
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (speed_at(middle) < options.speed ? low : high) = middle;
  }
  return [at, pace = high](double frame) { return at(pace * frame); };
}

// Straight pieces between poses, with the way along them measured in pixels of corner motion.
class Polyline {
 public:
  explicit Polyline(const Stage& stage, const Pose& start) : stage_(stage), poses_{start} {}

  double length() const { return way_.empty() ? 0 : way_.back(); }

  void append(const Pose& pose) {
    Pose last = poses_.back();
    for (int i = 1; i <= steps; ++i) {
      const Pose next = between(poses_.back(), pose, static_cast<double>(i) / steps);
      way_.push_back(length() + stage_.motion(last, next));
      last = next;
    }
    poses_.push_back(pose);
  }

  const Pose& last() const { return poses_.back(); }
  std::size_t pieces() const { return poses_.size() - 1; }
  const Pose& before_last() const { return poses_[poses_.size() - 2]; }

  Pose at(double way) const {
    const auto found = std::lower_bound(way_.begin(), way_.end(), way);
    if (found == way_.end()) return poses_.back();
    const std::size_t i = static_cast<std::size_t>(found - way_.begin());
    const double from = i == 0 ? 0 : way_[i - 1];
    const double share = way_[i] > from ? std::max(0.0, way - from) / (way_[i] - from) : 0;
    const std::size_t piece = i / steps;
    return between(poses_[piece], poses_[piece + 1], (static_cast<double>(i % steps) + share) / steps);
  }

 private:
  static constexpr int steps = 32;
  Stage stage_;
  std::vector<Pose> poses_;
  std::vector<double> way_;  // at the end of each step
};

// How far along its straight pieces something is when it starts and ends each at rest, and has its speed in between.
class Pace {
 public:
  Pace(double speed, int ease) : speed_(speed), ease_(ease) {}

  double frames() const { return pieces_.empty() ? 0 : pieces_.back().end; }

  void append(double length) {
    const double way = pieces_.empty() ? 0 : pieces_.back().way + pieces_.back().length;
    // Getting up to speed and to rest again takes the time of `ease` frames more than going on would.
    const double ease = std::min<double>(ease_, length / speed_);
    pieces_.push_back({way, length, frames(), frames() + length / speed_ + ease, ease});
  }

  double way_at(double frame) const {
    for (const Piece& piece : pieces_) {
      if (frame > piece.end && &piece != &pieces_.back()) continue;
      const double since = std::clamp(frame - piece.begin, 0.0, piece.end - piece.begin);
      const double left = piece.end - piece.begin - since;
      if (since < piece.ease) return piece.way + 0.5 * speed_ * since * since / piece.ease;
      if (left < piece.ease) return piece.way + piece.length - 0.5 * speed_ * left * left / piece.ease;
      return piece.way + speed_ * (since - 0.5 * piece.ease);
    }
    return 0;
  }

 private:
  struct Piece {
    double way, length;  // of its begin, pixels
    double begin, end;   // frames
    double ease;
  };
  double speed_;
  int ease_;
  std::vector<Piece> pieces_;
};

PoseAt sharp_motion(const Stage& stage, const MotionOptions& options, int frames, std::uint64_t seed) {
  if (options.turns > frames - 2) {
    throw Error(ErrorCode::invalid_argument, "motion: " + std::to_string(options.turns) + " turns do not fit into " +
                                                 std::to_string(frames) +
                                                 " frames; ask for fewer turns or more frames");
  }
  Random random(seed, 0x5a49);
  const auto random_pose = [&] {
    Placement p{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1), {}};
    do {
      for (int k = 0; k < 3; ++k) p.turn[k] = random.uniform(-1, 1);
    } while (p.turn.norm() > 1);
    p.turn *= options.rotation_range;
    return stage.pose(p);
  };
  const auto stays_in_view = [&](const Pose& from, const Pose& to) {
    for (const double share : {0.25, 0.5, 0.75, 1.0}) {
      if (!stage.in_view(between(from, to, share))) return false;
    }
    return true;
  };
  const auto turns_back = [&](const Polyline& path, const Pose& next) {
    if (path.pieces() == 0) return true;
    const Pose& here = path.last();
    const Pose before = between(here, path.before_last(), 0.01);
    const Pose after = between(here, next, 0.01);
    const Eigen::Vector3d in = stage.center_camera(here) - stage.center_camera(before);
    const Eigen::Vector3d out = stage.center_camera(after) - stage.center_camera(here);
    // A little more than 90 degrees, so that rounding cannot undo it.
    return in.dot(out) <= -0.05 * in.norm() * out.norm() && stage.flow(before, here).dot(stage.flow(here, after)) <= 0;
  };

  // One frame more at each end, for exposures that reach beyond the first and last.
  const double total = frames + 1.0;
  const double piece = options.speed * (total / (options.turns + 1) - options.ease);
  if (piece < options.speed * std::max(2, options.ease)) {
    throw Error(ErrorCode::invalid_argument,
                "motion: no time to get up to speed between so many turns; ask for fewer turns or a shorter ease");
  }
  const auto whole_frames = [&](double way) { return options.speed * std::floor(way / options.speed + 1e-6); };
  Polyline path(stage, random_pose());
  for (int i = 0; i < 200 && !stage.in_view(path.last()); ++i) path = Polyline(stage, random_pose());
  Pace pace(options.speed, options.ease);
  while (pace.frames() < total) {
    // Slightly shorter than an even share, so that the turns fit in; whole frames long, so that turns fall on frames.
    const double wanted = std::max(options.speed, whole_frames(piece * random.uniform(0.75, 1.0)));
    Pose best = path.last();
    double best_length = 0;
    for (int attempt = 0; attempt < 3000 && best_length < wanted; ++attempt) {
      Polyline trial(stage, path.last());
      trial.append(random_pose());
      const double length = std::min(wanted, whole_frames(trial.length()));
      if (length <= best_length) continue;
      const Pose candidate = trial.at(length);
      if (!stays_in_view(path.last(), candidate) || !turns_back(path, candidate)) continue;
      best = candidate;
      best_length = length;
    }
    if (best_length < std::min(wanted, 4.0 * options.speed)) {
      throw Error(ErrorCode::invalid_argument,
                  "motion: no room for sharp turns at that speed; lower the speed, ask for fewer turns or allow more "
                  "distance or rotation");
    }
    path.append(best);
    pace.append(best_length);
  }
  const double start = options.ease > 0 ? 0.0 : 1.0;
  return [path, pace, start](double frame) { return path.at(pace.way_at(frame + start)); };
}

void validate(const MotionOptions& options) {
  const auto check = [](bool fine, const char* what) {
    if (!fine) throw Error(ErrorCode::invalid_argument, std::string("motion: ") + what);
  };
  check(options.speed > 0 && std::isfinite(options.speed), "the speed must be a positive number of pixels a frame");
  check(options.nearest >= 0 && options.farthest >= 0, "distances must not be negative; 0 chooses them");
  check(options.rotation_range >= 0 && options.rotation_range <= std::numbers::pi,
        "the rotation range must be 0 to pi");
  check(options.turns >= 0, "the number of turns must not be negative");
  check(options.ease >= 0, "the frames to get up to speed must not be negative");
}

}  // namespace

PoseAt motion_through(std::vector<Pose> poses) {
  if (poses.empty()) throw Error(ErrorCode::invalid_argument, "motion: there are no poses; give one a frame");
  return [poses = std::move(poses)](double frame) {
    const int last = static_cast<int>(poses.size()) - 1;
    if (last == 0 || frame >= last + 0.5) return poses[static_cast<std::size_t>(last)];
    // Exposures that reach beyond the ends go straight on there.
    const int i = std::clamp(static_cast<int>(std::floor(frame)), 0, last - 1);
    return between(poses[static_cast<std::size_t>(i)], poses[static_cast<std::size_t>(i) + 1],
                   std::max(frame, -0.5) - i);
  };
}

std::array<Eigen::Vector3d, 8> bounding_corners(const Mesh& mesh) {
  Eigen::Vector3f low = mesh.positions.front(), high = low;
  for (const Eigen::Vector3f& p : mesh.positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  Corners corners;
  for (std::size_t i = 0; i < 8; ++i) {
    corners[i] = Eigen::Vector3f(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z())
                     .cast<double>();
  }
  return corners;
}

double corner_motion(const std::array<Eigen::Vector3d, 8>& corners, const Camera& camera, const Pose& T_camera_object_1,
                     const Pose& T_camera_object_2) {
  double farthest = 0;
  for (const Eigen::Vector3d& corner : corners) {
    const Eigen::Vector3d a = T_camera_object_1 * corner;
    const Eigen::Vector3d b = T_camera_object_2 * corner;
    farthest = std::max(
        farthest, std::hypot(camera.fx * (b.x() / b.z() - a.x() / a.z()), camera.fy * (b.y() / b.z() - a.y() / a.z())));
  }
  return farthest;
}

Eigen::Matrix3d MotionOptions::default_orientation() {
  Eigen::Matrix3d upright = Eigen::Vector3d(1, -1, -1).asDiagonal();  // y up, facing the camera
  return Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(0.55, Eigen::Vector3d::UnitY()) * upright;
}

PoseAt make_motion(const MotionOptions& options, const Mesh& mesh, const Camera& camera, int frames,
                   std::uint64_t seed) {
  if (!options.T_camera_object.empty()) return motion_through(options.T_camera_object);
  validate(options);
  const Stage stage(options, mesh, camera);
  switch (options.style) {
    case MotionStyle::smooth:
      return smooth_motion(stage, options, frames, seed);
    case MotionStyle::sharp:
      return sharp_motion(stage, options, frames, seed);
    case MotionStyle::still:
      break;
  }
  return [pose = stage.pose({})](double) { return pose; };
}

MotionSummary summarize_motion(const std::vector<Pose>& poses, const Mesh& mesh, const Camera& camera) {
  MotionSummary summary;
  const Corners corners = bounding_corners(mesh);
  const Eigen::Vector3d center = 0.5 * (corners.front() + corners.back());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double distance = (poses[i] * center).z();
    summary.nearest = i == 0 ? distance : std::min(summary.nearest, distance);
    summary.farthest = std::max(summary.farthest, distance);
    if (i + 1 < poses.size()) summary.corner_speed.push_back(corner_motion(corners, camera, poses[i], poses[i + 1]));
    if (i > 0 && i + 1 < poses.size()) {
      const Eigen::Vector3d in = (poses[i] * center) - (poses[i - 1] * center);
      const Eigen::Vector3d out = (poses[i + 1] * center) - (poses[i] * center);
      if (in.norm() > 0 && out.norm() > 0 && in.dot(out) <= 0) ++summary.turns;
    }
  }
  if (summary.corner_speed.empty()) return summary;
  std::vector<double> sorted = summary.corner_speed;
  std::sort(sorted.begin(), sorted.end());
  summary.median_speed = sorted[sorted.size() / 2];
  summary.speed_95 = sorted[static_cast<std::size_t>(0.95 * static_cast<double>(sorted.size() - 1))];
  summary.max_speed = sorted.back();
  return summary;
}

}  // namespace holdfast::simulation
