#include "init/pose_from_points.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "holdfast/error.hpp"

namespace holdfast::app {
namespace {

constexpr std::size_t kLeastPairs = 4;
constexpr std::size_t kLeastPairsForFocal = 6;
/// Points whose spread across their main direction is below this share of the spread along it lie on a line.
constexpr double kCollinear = 1e-3;
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
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

[[noreturn]] void fail(const std::string& message) { throw Error(ErrorCode::pose, "point pairs: " + message); }

Vector3d centroid(const std::vector<PointPair>& pairs) {
  Vector3d sum = Vector3d::Zero();
  for (const PointPair& pair : pairs) {
    sum += pair.p_object;
  }
  return sum / static_cast<double>(pairs.size());
}

/// Spread of the model's points along their main directions, metres, largest first.
Vector3d spreads(const std::vector<PointPair>& pairs) {
  const Vector3d middle = centroid(pairs);
  MatrixXd offsets(3, pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    offsets.col(static_cast<Eigen::Index>(i)) = pairs[i].p_object - middle;
  }
  return Eigen::JacobiSVD<MatrixXd>(offsets).singularValues();
}

bool are_collinear(const std::vector<PointPair>& pairs) {
  const Vector3d spread = spreads(pairs);
  return !(spread[1] > kCollinear * spread[0]);
}

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

bool are_coplanar(const std::vector<PointPair>& pairs) {
  const Vector3d spread = spreads(pairs);
  return spread[2] < kCollinear * spread[0];
}

/// Least squares over pose and, where asked, focal length. The pose is moved about the points' centre in the camera
/// frame, in units of its distance: translation and rotation then hardly mix, and all parameters are of one size.
class Refinement {
 public:
  Refinement(const std::vector<PointPair>& pairs, bool with_focal) : pairs_(pairs), parameters_(with_focal ? 7 : 6) {}

  struct Estimate {
    Pose T_camera_object = Pose::Identity();
    Camera camera;
    double squared_sum = std::numeric_limits<double>::infinity();
    double rms(std::size_t count) const { return std::sqrt(squared_sum / static_cast<double>(count)); }
  };

  /// Levenberg-Marquardt; the sum stays infinite where points are behind the camera.
  Estimate minimize(const Pose& T_start, const Camera& camera) const {
    Estimate best{T_start, camera, squared_sum(T_start, camera)};
    double damping = 1e-3;
    for (int iteration = 0; iteration < 100 && std::isfinite(best.squared_sum) && damping < 1e12; ++iteration) {
      const MatrixXd jacobian = jacobian_at(best);
      const MatrixXd normal = jacobian.transpose() * jacobian;
      const VectorXd gradient = jacobian.transpose() * stacked_residuals(best.T_camera_object, best.camera);
      MatrixXd damped = normal;
      damped.diagonal() += damping * normal.diagonal();
      const VectorXd step = -damped.ldlt().solve(gradient);
      Estimate next = step.allFinite() ? moved(best, step) : best;
      next.squared_sum = squared_sum(next.T_camera_object, next.camera);
      if (next.squared_sum < best.squared_sum) {
        const bool converged = best.squared_sum - next.squared_sum < 1e-14 * best.squared_sum || step.norm() < 1e-12;
        best = next;
        damping *= 0.1;
        if (converged) {
          break;
        }
      } else {
        damping *= 10;
      }
    }
    return best;
  }

  /// Standard deviation of a pixel coordinate that the residuals speak of.
  double pixel_sigma(const Estimate& estimate) const {
    const auto freedom = static_cast<double>(2 * pairs_.size()) - static_cast<double>(parameters_);
    return std::max(kLeastPixelSigma, std::sqrt(estimate.squared_sum / std::max(freedom, 1.0)));
  }

  /// Standard deviations for pixels of standard deviation 1: translation as a share of the distance (3), rotation in
  /// radians (3), log focal length.
  VectorXd sigmas_per_pixel(const Estimate& estimate) const {
    const MatrixXd jacobian = jacobian_at(estimate);
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(jacobian.transpose() * jacobian);
    const VectorXd variances = eigen.eigenvalues().cwiseMax(1e-12).cwiseInverse();
    return (eigen.eigenvectors().cwiseAbs2() * variances).cwiseSqrt();
  }

 private:
  Estimate moved(const Estimate& from, const VectorXd& step) const {
    const Vector3d center = from.T_camera_object * centroid(pairs_);
    Twist twist;
    twist << step.head<3>() * center.norm(), step.segment<3>(3);
    Estimate to = from;
    to.T_camera_object = renormalized(Eigen::Translation3d(center) * exp_se3(twist) * Eigen::Translation3d(-center) *
                                      from.T_camera_object);
    if (parameters_ == 7) {
      to.camera.fx = to.camera.fy = from.camera.fx * std::exp(step[6]);
    }
    return to;
  }

  VectorXd stacked_residuals(const Pose& T_camera_object, const Camera& camera) const {
    const std::vector<Vector2d> residuals = point_residuals(pairs_, camera, T_camera_object);
    VectorXd stacked(2 * static_cast<Eigen::Index>(residuals.size()));
    for (std::size_t i = 0; i < residuals.size(); ++i) {
      stacked.segment<2>(2 * static_cast<Eigen::Index>(i)) = residuals[i];
    }
    return stacked;
  }

  double squared_sum(const Pose& T_camera_object, const Camera& camera) const {
    const double sum = stacked_residuals(T_camera_object, camera).squaredNorm();
    return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
  }

  MatrixXd jacobian_at(const Estimate& estimate) const {
    constexpr double step = 1e-6;
    MatrixXd jacobian(2 * pairs_.size(), parameters_);
    for (Eigen::Index i = 0; i < parameters_; ++i) {
      const Estimate up = moved(estimate, step * VectorXd::Unit(parameters_, i));
      const Estimate down = moved(estimate, -step * VectorXd::Unit(parameters_, i));
      jacobian.col(i) =
          (stacked_residuals(up.T_camera_object, up.camera) - stacked_residuals(down.T_camera_object, down.camera)) /
          (2 * step);
    }
    return jacobian;
  }

  const std::vector<PointPair>& pairs_;
  Eigen::Index parameters_;
};

using Estimate = Refinement::Estimate;

Pose to_pose(const cv::Mat& rotation_vector, const cv::Mat& translation) {
  cv::Mat rotation;
  cv::Rodrigues(rotation_vector, rotation);
  Matrix3d R;
  Vector3d t;
  cv::cv2eigen(rotation, R);
  cv::cv2eigen(translation, t);
  Pose pose = Pose::Identity();
  pose.linear() = R;
  pose.translation() = t;
  return pose;
}

/// Rays through the pixels, as points of the plane z = 1, without distortion.
std::vector<cv::Point2d> rays(const std::vector<PointPair>& pairs, const Camera& camera) {
  std::vector<cv::Point2d> pixels;
  for (const PointPair& pair : pairs) {
    pixels.emplace_back(pair.pixel.x(), pair.pixel.y());
  }
  const cv::Matx33d matrix(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  const bool fisheye = camera.lens == LensModel::fisheye;
  const cv::Mat distortion(1, fisheye ? 4 : 8, CV_64F, const_cast<double*>(camera.distortion.data()));
  std::vector<cv::Point2d> undistorted;
  if (fisheye) {
    cv::fisheye::undistortPoints(pixels, undistorted, matrix, distortion);
  } else {
    cv::undistortPoints(pixels, undistorted, matrix, distortion);
  }
  return undistorted;
}

/// Closed-form poses, none of whose methods is good for all configurations.
std::vector<Pose> closed_form_poses(const std::vector<PointPair>& pairs, const std::vector<cv::Point2d>& rays,
                                    bool coplanar) {
  std::vector<cv::Point3d> points;
  for (const PointPair& pair : pairs) {
    points.emplace_back(pair.p_object.x(), pair.p_object.y(), pair.p_object.z());
  }
  std::vector<Pose> poses;
  std::vector<cv::SolvePnPMethod> methods{cv::SOLVEPNP_SQPNP, cv::SOLVEPNP_EPNP};
  if (coplanar) {
    methods.push_back(cv::SOLVEPNP_IPPE);
  }
  for (const cv::SolvePnPMethod method : methods) {
    try {
      std::vector<cv::Mat> rotations;
      std::vector<cv::Mat> translations;
      cv::solvePnPGeneric(points, rays, cv::Matx33d::eye(), cv::noArray(), rotations, translations, false, method);
      for (std::size_t i = 0; i < rotations.size(); ++i) {
        poses.push_back(to_pose(rotations[i], translations[i]));
      }
    } catch (const cv::Exception&) {
      continue;  // this method does not take this configuration; another start does
    }
  }
  return poses;
}

/// The translation that brings the points nearest to their rays under a rotation.
Vector3d translation_for(const Matrix3d& rotation, const std::vector<PointPair>& pairs,
                         const std::vector<cv::Point2d>& rays) {
  Matrix3d normal = Matrix3d::Zero();
  Vector3d right_side = Vector3d::Zero();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const Vector3d ray = Vector3d(rays[i].x, rays[i].y, 1).normalized();
    const Matrix3d across = Matrix3d::Identity() - ray * ray.transpose();
    normal += across;
    right_side -= across * (rotation * pairs[i].p_object);
  }
  return normal.ldlt().solve(right_side);
}

/// A pose for each of the 24 ways to put a cube: between them and the closed forms no minimum goes unseen.
std::vector<Pose> spread_poses(const std::vector<PointPair>& pairs, const std::vector<cv::Point2d>& rays) {
  const double quarter = std::acos(0.0);
  std::vector<Pose> poses;
  for (int face = 0; face < 6; ++face) {
    const Matrix3d facing =
        face < 4 ? Eigen::AngleAxisd(face * quarter, Vector3d::UnitY()).toRotationMatrix()
                 : Eigen::AngleAxisd((face == 4 ? 1 : -1) * quarter, Vector3d::UnitX()).toRotationMatrix();
    for (int turn = 0; turn < 4; ++turn) {
      Pose pose = Pose::Identity();
      pose.linear() = Eigen::AngleAxisd(turn * quarter, Vector3d::UnitZ()).toRotationMatrix() * facing;
      pose.translation() = translation_for(pose.linear(), pairs, rays);
      poses.push_back(pose);
    }
  }
  return poses;
}

/// All minima that refinement finds, best first.
std::vector<Estimate> minima(const std::vector<PointPair>& pairs, const Camera& camera, const Refinement& refinement) {
  const std::vector<cv::Point2d> to_pixels = rays(pairs, camera);
  std::vector<Pose> starts = closed_form_poses(pairs, to_pixels, are_coplanar(pairs));
  const std::vector<Pose> spread = spread_poses(pairs, to_pixels);
  starts.insert(starts.end(), spread.begin(), spread.end());
  std::vector<Estimate> found;
  for (const Pose& start : starts) {
    if (!start.matrix().allFinite()) {
      continue;
    }
    const Estimate estimate = refinement.minimize(start, camera);
    if (std::isfinite(estimate.squared_sum)) {
      found.push_back(estimate);
    }
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Estimate& a, const Estimate& b) { return a.squared_sum < b.squared_sum; });
  return found;
}

/// A pose turned away from the best that fits about as well.
const Estimate* rival(const std::vector<Estimate>& found, std::size_t count) {
  const auto other = std::find_if(found.begin() + 1, found.end(), [&](const Estimate& estimate) {
    const Matrix3d between = found.front().T_camera_object.linear().transpose() * estimate.T_camera_object.linear();
    return rotation_angle(between) > 0.1;
  });
  const bool fits = other != found.end() && other->rms(count) < 1.5 * found.front().rms(count) + kLeastPixelSigma;
  return fits ? &*other : nullptr;
}

/// For each pair whether it agrees with most others to a pose with this camera; all false: there are no such.
std::vector<bool> agreeing(const std::vector<PointPair>& pairs, const Camera& camera) {
  std::vector<cv::Point3d> points;
  for (const PointPair& pair : pairs) {
    points.emplace_back(pair.p_object.x(), pair.p_object.y(), pair.p_object.z());
  }
  std::vector<bool> agree(pairs.size());
  cv::Mat rotation, translation;
  std::vector<int> inliers;
  constexpr int kTrials = 2000;
  constexpr double kConfidence = 0.9999;
  try {
    if (cv::solvePnPRansac(points, rays(pairs, camera), cv::Matx33d::eye(), cv::noArray(), rotation, translation, false,
                           kTrials, static_cast<float>(kMistakenResidual / camera.fx), kConfidence, inliers,
                           cv::SOLVEPNP_P3P)) {
      for (const int i : inliers) {
        agree[static_cast<std::size_t>(i)] = true;
      }
    }
  } catch (const cv::Exception&) {
    // No sample determines a pose.
  }
  return agree;
}

std::string listed_names(const std::vector<PointPair>& pairs) {
  std::string names;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    names += (i == 0 ? "" : i + 1 == pairs.size() ? " and " : ", ") + pairs[i].name;
  }
  return names;
}

double largest_residual(const std::vector<PointPair>& pairs, const Estimate& estimate) {
  double largest = 0;
  for (const Vector2d& residual : point_residuals(pairs, estimate.camera, estimate.T_camera_object)) {
    largest = std::max(largest, residual.norm());
  }
  return largest;
}

PoseFromPoints judged(const std::vector<PointPair>& pairs, const std::vector<Estimate>& found,
                      const Refinement& refinement, bool with_focal) {
  if (found.empty()) {
    fail("no pose has all points before the camera: check that x,y,z belong to u,v on each line");
  }
  const Estimate& best = found.front();
  const double pixel_sigma = refinement.pixel_sigma(best);
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
  if (with_focal) {
    result.focal_sigma = pixel_sigma * refinement.sigmas_per_pixel(best)[6] * best.camera.fx;
    if (sigmas[6] > kDoubtfulFocalSigma) {
      result.warnings.push_back(
          fmt::format("the focal length is uncertain ({:.0f} +- {:.0f} px): add points at more "
                      "different depths",
                      best.camera.fx, result.focal_sigma));
    }
  }
  if (const Estimate* other = rival(found, pairs.size())) {
    result.warnings.push_back(fmt::format(
        "another pose, turned by {:.0f} degrees, fits nearly as well ({:.1f} px against {:.1f}): check the picture, "
        "and add a point off the others' plane",
        rotation_angle(best.T_camera_object.linear().transpose() * other->T_camera_object.linear()) * 180 / M_PI,
        other->rms(pairs.size()), result.rms));
  }
  const auto worst =
      std::max_element(result.residuals.begin(), result.residuals.end(),
                       [](const Vector2d& a, const Vector2d& b) { return a.squaredNorm() < b.squaredNorm(); });
  if (worst->norm() > kMistakenResidual) {
    result.warnings.push_back(
        fmt::format("the points do not belong together: that of {} is {:.0f} px off, but another may be the mistaken "
                    "one; check that x,y,z belong to u,v on each line",
                    pairs[static_cast<std::size_t>(worst - result.residuals.begin())].name, worst->norm()));
  }
  return result;
}

/// `fit` finds all minima of some pairs, best first; `cameras` are those that mistaken pairs are looked for with.
template <class Fit>
PoseFromPoints without_mistaken(const std::vector<PointPair>& pairs, std::size_t least, bool with_focal,
                                const std::vector<Camera>& cameras, const Fit& fit) {
  const std::vector<Estimate> of_all = fit(pairs);
  if (!of_all.empty() && largest_residual(pairs, of_all.front()) <= kMistakenResidual) {
    return judged(pairs, of_all, Refinement(pairs, with_focal), with_focal);
  }
  std::vector<bool> most(pairs.size());
  for (const Camera& camera : cameras) {
    std::vector<bool> agree = agreeing(pairs, camera);
    if (std::count(agree.begin(), agree.end(), true) > std::count(most.begin(), most.end(), true)) most = agree;
  }
  std::vector<PointPair> kept, mistaken;
  for (std::size_t i = 0; i < pairs.size(); ++i) (most[i] ? kept : mistaken).push_back(pairs[i]);
  // As few as determine a pose agree with any.
  if (kept.size() > least && 2 * kept.size() > pairs.size() && !are_collinear(kept)) {
    const std::vector<Estimate> of_kept = fit(kept);
    if (!of_kept.empty() && largest_residual(kept, of_kept.front()) <= kMistakenResidual) {
      PoseFromPoints result = judged(kept, of_kept, Refinement(kept, with_focal), with_focal);
      result.warnings.insert(
          result.warnings.begin(),
          fmt::format("left out: the point of {}, which the other {} put elsewhere by {:.0f} px or more; check that "
                      "x,y,z belong to u,v there",
                      listed_names(mistaken), kept.size(), kMistakenResidual));
      return result;
    }
  }
  return judged(pairs, of_all, Refinement(pairs, with_focal), with_focal);
}

}  // namespace

PoseFromPoints pose_from_points(const std::vector<PointPair>& pairs, const Camera& camera) {
  require_enough(pairs, kLeastPairs, "a pose");
  return without_mistaken(pairs, kLeastPairs, false, {camera}, [&camera](const std::vector<PointPair>& some) {
    return minima(some, camera, Refinement(some, false));
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
    const Refinement fixed_focal(some, false);
    const Refinement refinement(some, true);
    std::vector<Estimate> found;
    for (const Camera& camera : cameras) {
      const std::vector<Estimate> starts = minima(some, camera, fixed_focal);
      for (std::size_t i = 0; i < std::min<std::size_t>(starts.size(), 6); ++i) {
        const Estimate estimate = refinement.minimize(starts[i].T_camera_object, starts[i].camera);
        if (std::isfinite(estimate.squared_sum)) {
          found.push_back(estimate);
        }
      }
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const Estimate& a, const Estimate& b) { return a.squared_sum < b.squared_sum; });
    return found;
  };
  return without_mistaken(pairs, kLeastPairsForFocal, true, cameras, fit);
}

std::vector<Vector2d> point_residuals(const std::vector<PointPair>& pairs, const Camera& camera,
                                      const Pose& T_camera_object) {
  std::vector<Vector2d> residuals;
  for (const PointPair& pair : pairs) {
    const Vector3d p_camera = T_camera_object * pair.p_object;
    const bool before = p_camera.z() > 0;
    const Vector2d pixel = before ? camera.project(p_camera) : Vector2d::Constant(std::nan(""));
    residuals.push_back((before && camera.has_distortion() ? camera.distort(pixel) : pixel) - pair.pixel);
  }
  return residuals;
}

double root_mean_square(const std::vector<Vector2d>& residuals) {
  double sum = 0;
  for (const Vector2d& residual : residuals) {
    sum += residual.squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(residuals.size()));
}

}  // namespace holdfast::app
