#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "base/corner_motion.hpp"
#include "recovery/keyframes.hpp"
#include "recovery/shift_search.hpp"

namespace holdfast {

/// A pose and how well the frame's gradients agree with it on some level, at most 1.
struct PoseCandidate {
  Pose T_camera_object = Pose::Identity();
  double score = 0;
};

/// Draws the view at a pose on one level; false where it is out of view.
using DrawView = std::function<bool(const Pose& T_camera_object, int level)>;

/// Looks for a lost object by its texture over the whole picture: view templates of a plan of appearances, shifted over
/// a coarse level, a part of the plan in each frame; the best are looked at more closely. Proposes poses, decides
/// nothing.
class Relocalizer {
 public:
  /// Candidates that are tracked from, and that the next frame looks at again.
  static constexpr std::size_t kMostCandidates = 3;

  Relocalizer(const std::vector<Level>& levels, const Extent& extent, ShiftSearch& search, ViewTemplate& view,
              DeviceImage& image);

  void clear();
  /// The object was surely held at this pose.
  void remember(const Pose& T_camera_object) { keyframes_.remember(T_camera_object); }
  /// Begins a search for an object last seen at this pose, unless one is going on.
  void begin(const Pose& T_last);
  void end() { searching_ = false; }
  bool searching() const { return searching_; }
  /// Appearances that a sweep of the whole plan takes.
  int planned() const { return keyframes_.planned(); }

  /// Levels of a search: the whole picture on `swept`, candidates on `closer`, alignments from `coarsest`.
  struct Levels {
    int swept = 0, closer = 0, coarsest = 0;
  };
  Levels levels_for(const Pose& T_last, int finest, int most_levels) const;

  /// The best places for the object, best first, after a sweep of the next appearances that `budget_ms` allows. Blurred
  /// levels of the frame must have been enqueued from coarsest to swept.
  std::vector<PoseCandidate> search(const DrawView& draw, const Levels& levels, double budget_ms);

  /// Near where it is expected, behind an occluder that hides most of it: places where a part of its view is seen.
  std::vector<PoseCandidate> search_parts(const DrawView& draw, const Pose& T_expected, int level);

  /// The found pose turned about the picture's axes, and its mirrored tilt: what it may have been taken for.
  std::vector<PoseCandidate> rivals(const DrawView& draw, const Pose& T_found, int closer, int finest);

  /// Candidates that led to a start worth following; looked at again in the next frame.
  void keep(std::vector<PoseCandidate> candidates) { last_ = std::move(candidates); }

 private:
  PoseCandidate looked_at(const DrawView& draw, const Pose& T_camera_object, int level, int reach);
  PoseCandidate turned_to_fit(const DrawView& draw, const PoseCandidate& candidate, int level);
  void keep_best(std::vector<PoseCandidate>& candidates, std::size_t count, int level) const;

  const std::vector<Level>& levels_;
  Extent extent_;
  ShiftSearch& search_;
  ViewTemplate& view_;
  DeviceImage& image_;
  Keyframes keyframes_;
  std::vector<PoseCandidate> last_;
  Pose T_last_ = Pose::Identity();
  bool searching_ = false;
};

/// The pose turned about the camera as its view was shifted on a level of this camera, so that it looks the same there.
Pose shifted(const Pose& T_camera_object, const Eigen::Vector3d& p_object_center, const Camera& camera,
             const ShiftSearch::Result& shift);

/// The pose turned about an axis through the object's centre, camera axes, radians.
Pose turned_about_center(const Pose& T_camera_object, const Extent& extent, const Eigen::Vector3d& axis, double angle);

}  // namespace holdfast
