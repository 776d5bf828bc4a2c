#include "init/pose_from_points.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "holdfast/error.hpp"
#include "init/point_refinement.hpp"
#include "init/point_residuals.hpp"
#include "init/point_spread.hpp"
#include "init/pose_starts.hpp"

namespace holdfast::app {
namespace {

constexpr std::size_t kLeastPairs = 4;
constexpr std::size_t kLeastPairsForFocal = 6;
/// Clicks and corner detectors are no better than this; a perfect fit must not make a weak geometry look certain.
constexpr double kLeastPixelSigma = 0.5;
constexpr double kImprecisePixelSigma = 3;
/// A pose less certain than this is not determined by its points.
constexpr double kMostRotationSigma = 0.35;  // radians
constexpr double kMostDistanceSigma = 0.35;  // of the distance
constexpr double kMostFocalSigma = 0.35;     // of the focal length
constexpr double kDoubtfulFocalSigma = 0.1;
/// Residuals above this look like a mistaken pair rather than an imprecise one, pixels.
constexpr double kMistakenResidual = 10;

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

[[noreturn]] void fail(const std::string& message) { throw Error(ErrorCode::pose, "point pairs: " + message); }

void require_enough(const std::vector<PointPair>& pairs, std::size_t least, const char* purpose) {
  std::vector<Vector3d> distinct;
  for (const PointPair& pair : pairs) {
    if (std::find(distinct.begin(), distinct.end(), pair.p_object) == distinct.end()) {
      distinct.push_back(pair.p_object);
    }
  }
  if (distinct.size() < least) {
    fail(fmt::format("{} different points of the model; {} needs {} or more", distinct.size(), purpose, least));
  }
  if (are_collinear(pairs)) {
    fail("all points lie on one line, which leaves the turn about it open: add a point off the line");
  }
}

/// All minima that refinement finds, best first.
std::vector<PointEstimate> minima(const std::vector<PointPair>& pairs, const Camera& camera,
                                  const PointRefinement& refinement) {
  std::vector<PointEstimate> found;
  for (const Pose& start : pose_starts(pairs, camera)) {
    if (!start.matrix().allFinite()) {
      continue;
    }
    const PointEstimate estimate = refinement.minimize(start, camera);
    if (std::isfinite(estimate.squared_sum)) {
      found.push_back(estimate);
    }
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const PointEstimate& a, const PointEstimate& b) { return a.squared_sum < b.squared_sum; });
  return found;
}

/// A pose turned away from the best that fits about as well.
const PointEstimate* rival(const std::vector<PointEstimate>& found, std::size_t count) {
  const auto other = std::find_if(found.begin() + 1, found.end(), [&](const PointEstimate& estimate) {
    const Matrix3d between = found.front().T_camera_object.linear().transpose() * estimate.T_camera_object.linear();
    return rotation_angle(between) > 0.1;
  });
  const bool fits = other != found.end() && other->rms(count) < 1.5 * found.front().rms(count) + kLeastPixelSigma;
  return fits ? &*other : nullptr;
}

std::string listed_names(const std::vector<PointPair>& pairs) {
  std::string names;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    names += (i == 0 ? "" : i + 1 == pairs.size() ? " and " : ", ") + pairs[i].name;
  }
  return names;
}

Vector3d middle(const std::vector<PointPair>& pairs) {
  Vector3d sum = Vector3d::Zero();
  for (const PointPair& pair : pairs) sum += pair.p_object;
  return sum / static_cast<double>(pairs.size());
}

double largest_residual(const std::vector<PointPair>& pairs, const PointEstimate& estimate) {
  double largest = 0;
  for (const Vector2d& residual : point_residuals(pairs, estimate.camera, estimate.T_camera_object)) {
    largest = std::max(largest, residual.norm());
  }
  return largest;
}

std::size_t farthest(const std::vector<Vector2d>& residuals) {
  const auto found = std::max_element(residuals.begin(), residuals.end(), [](const Vector2d& a, const Vector2d& b) {
    return a.squaredNorm() < b.squaredNorm();
  });
  return static_cast<std::size_t>(found - residuals.begin());
}

PoseFromPoints judged(const std::vector<PointPair>& pairs, const std::vector<PointEstimate>& found,
                      const PointRefinement& refinement, bool with_focal) {
  if (found.empty()) {
    fail("no pose has all points before the camera: check that x,y,z belong to u,v on each line");
  }
  const PointEstimate& best = found.front();
  const double pixel_sigma = refinement.pixel_sigma(best, kLeastPixelSigma);
  // Whether the points' places suffice does not depend on a mistaken pair among them: that has a warning of its own.
  const VectorXd sigmas = std::min(pixel_sigma, kImprecisePixelSigma) * refinement.sigmas_per_pixel(best);
  if (with_focal && !(sigmas[6] < kMostFocalSigma)) {
    fail(
        fmt::format("they do not determine the focal length ({:.0f} +- {:.0f} px): take points at more different "
                    "depths, or give --camera",
                    best.camera.fx, sigmas[6] * best.camera.fx));
  }
  if (!(sigmas.segment<3>(3).maxCoeff() < kMostRotationSigma) || !(sigmas.head<3>().maxCoeff() < kMostDistanceSigma)) {
    fail("they do not determine the pose: spread them over all of the object that is seen");
  }
  PoseFromPoints result;
  result.T_camera_object = best.T_camera_object;
  result.camera = best.camera;
  result.pairs = pairs;
  result.residuals = point_residuals(pairs, best.camera, best.T_camera_object);
  result.rms = root_mean_square(result.residuals);
  const VectorXd honest_sigmas = pixel_sigma * refinement.sigmas_per_pixel(best);
  result.position_sigma = honest_sigmas.head<3>().norm() * (best.T_camera_object * middle(pairs)).norm();
  result.rotation_sigma = honest_sigmas.segment<3>(3).norm();
  if (with_focal) {
    result.focal_sigma = honest_sigmas[6] * best.camera.fx;
    if (sigmas[6] > kDoubtfulFocalSigma) {
      result.warnings.push_back(
          fmt::format("the focal length is uncertain ({:.0f} +- {:.0f} px): add points at more "
                      "different depths",
                      best.camera.fx, result.focal_sigma));
    }
  }
  if (const PointEstimate* other = rival(found, pairs.size())) {
    result.warnings.push_back(fmt::format(
        "another pose, turned by {:.0f} degrees, fits nearly as well ({:.1f} px against {:.1f}): check the picture, "
        "and add a point off the others' plane",
        rotation_angle(best.T_camera_object.linear().transpose() * other->T_camera_object.linear()) * 180 / M_PI,
        other->rms(pairs.size()), result.rms));
  }
  const std::size_t worst = farthest(result.residuals);
  if (result.residuals[worst].norm() > kMistakenResidual) {
    result.warnings.push_back(
        fmt::format("the points do not belong together: that of {} is {:.0f} px off, but another may be the mistaken "
                    "one; check that x,y,z belong to u,v on each line",
                    pairs[worst].name, result.residuals[worst].norm()));
  }
  return result;
}

/// `fit` finds all minima of some pairs, best first; `cameras` are those that mistaken pairs are looked for with.
template <class Fit>
PoseFromPoints without_mistaken(const std::vector<PointPair>& pairs, std::size_t least, bool with_focal,
                                const std::vector<Camera>& cameras, const Fit& fit) {
  const std::vector<PointEstimate> of_all = fit(pairs);
  if (!of_all.empty() && largest_residual(pairs, of_all.front()) <= kMistakenResidual) {
    return judged(pairs, of_all, PointRefinement(pairs, with_focal), with_focal);
  }
  std::vector<bool> most(pairs.size());
  for (const Camera& camera : cameras) {
    std::vector<bool> agree = agreeing(pairs, camera, kMistakenResidual);
    if (std::count(agree.begin(), agree.end(), true) > std::count(most.begin(), most.end(), true)) most = agree;
  }
  std::vector<PointPair> kept, mistaken;
  for (std::size_t i = 0; i < pairs.size(); ++i) (most[i] ? kept : mistaken).push_back(pairs[i]);
  // As few as determine a pose agree with any.
  if (kept.size() > least && 2 * kept.size() > pairs.size() && !are_collinear(kept)) {
    const std::vector<PointEstimate> of_kept = fit(kept);
    if (!of_kept.empty() && largest_residual(kept, of_kept.front()) <= kMistakenResidual) {
      PoseFromPoints result = judged(kept, of_kept, PointRefinement(kept, with_focal), with_focal);
      result.warnings.insert(
          result.warnings.begin(),
          fmt::format("left out: the point of {}, which the other {} put elsewhere by {:.0f} px or more; check that "
                      "x,y,z belong to u,v there",
                      listed_names(mistaken), kept.size(), kMistakenResidual));
      // The pose gives way to one of two points that were taken for each other.
      const std::size_t worst = farthest(result.residuals);
      if (const double off = result.residuals[worst].norm(); off > kImprecisePixelSigma) {
        result.warnings.push_back(
            fmt::format("the point of {} is still {:.1f} px off: is it mistaken, too?", kept[worst].name, off));
      }
      return result;
    }
  }
  return judged(pairs, of_all, PointRefinement(pairs, with_focal), with_focal);
}

}  // namespace

PoseFromPoints pose_from_points(const std::vector<PointPair>& pairs, const Camera& camera) {
  require_enough(pairs, kLeastPairs, "a pose");
  return without_mistaken(pairs, kLeastPairs, false, {camera}, [&camera](const std::vector<PointPair>& some) {
    return minima(some, camera, PointRefinement(some, false));
  });
}

PoseFromPoints pose_and_focal_from_points(const std::vector<PointPair>& pairs, int width, int height) {
  require_enough(pairs, kLeastPairsForFocal, "the focal length");
  // From fish-eye-like to long lenses; the best poses at each fixed focal length start the joint refinement.
  std::vector<Camera> cameras;
  for (const double focal_over_width : {0.4, 0.6, 0.9, 1.3, 2.0, 3.0, 5.0}) {
    const double focal = focal_over_width * std::max(width, height);
    cameras.push_back({width, height, focal, focal, (width - 1) / 2.0, (height - 1) / 2.0, {}});
  }
  const auto fit = [&cameras](const std::vector<PointPair>& some) {
    const PointRefinement fixed_focal(some, false);
    const PointRefinement refinement(some, true);
    std::vector<PointEstimate> found;
    for (const Camera& camera : cameras) {
      const std::vector<PointEstimate> starts = minima(some, camera, fixed_focal);
      for (std::size_t i = 0; i < std::min<std::size_t>(starts.size(), 6); ++i) {
        const PointEstimate estimate = refinement.minimize(starts[i].T_camera_object, starts[i].camera);
        if (std::isfinite(estimate.squared_sum)) {
          found.push_back(estimate);
        }
      }
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const PointEstimate& a, const PointEstimate& b) { return a.squared_sum < b.squared_sum; });
    return found;
  };
  return without_mistaken(pairs, kLeastPairsForFocal, true, cameras, fit);
}

}  // namespace holdfast::app
