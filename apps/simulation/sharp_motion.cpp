#include "simulation/sharp_motion.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "holdfast/error.hpp"
#include "simulation/random.hpp"

namespace holdfast::simulation {
namespace {

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

// Way along straight pieces, each begun and ended at rest, with the full speed in between.
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

}  // namespace

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

}  // namespace holdfast::simulation
