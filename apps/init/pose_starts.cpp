#include "init/pose_starts.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>

#include "init/point_spread.hpp"

namespace holdfast::app {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

std::vector<cv::Point3d> points_of(const std::vector<PointPair>& pairs) {
  std::vector<cv::Point3d> points;
  for (const PointPair& pair : pairs) {
    points.emplace_back(pair.p_object.x(), pair.p_object.y(), pair.p_object.z());
  }
  return points;
}

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
  std::vector<Pose> poses;
  std::vector<cv::SolvePnPMethod> methods{cv::SOLVEPNP_SQPNP, cv::SOLVEPNP_EPNP};
  if (coplanar) {
    methods.push_back(cv::SOLVEPNP_IPPE);
  }
  for (const cv::SolvePnPMethod method : methods) {
    try {
      std::vector<cv::Mat> rotations;
      std::vector<cv::Mat> translations;
      cv::solvePnPGeneric(points_of(pairs), rays, cv::Matx33d::eye(), cv::noArray(), rotations, translations, false,
                          method);
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

/// A pose for each of the 24 ways to put a cube.
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

}  // namespace

std::vector<Pose> pose_starts(const std::vector<PointPair>& pairs, const Camera& camera) {
  const std::vector<cv::Point2d> to_pixels = rays(pairs, camera);
  std::vector<Pose> starts = closed_form_poses(pairs, to_pixels, are_coplanar(pairs));
  const std::vector<Pose> spread = spread_poses(pairs, to_pixels);
  starts.insert(starts.end(), spread.begin(), spread.end());
  return starts;
}

std::vector<bool> agreeing(const std::vector<PointPair>& pairs, const Camera& camera, double pixels) {
  std::vector<bool> agree(pairs.size());
  cv::Mat rotation, translation;
  std::vector<int> inliers;
  constexpr int kTrials = 2000;
  constexpr double kConfidence = 0.9999;
  try {
    if (cv::solvePnPRansac(points_of(pairs), rays(pairs, camera), cv::Matx33d::eye(), cv::noArray(), rotation,
                           translation, false, kTrials, static_cast<float>(pixels / camera.fx), kConfidence, inliers,
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

}  // namespace holdfast::app
