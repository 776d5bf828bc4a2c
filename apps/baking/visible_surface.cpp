#include "baking/visible_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace holdfast::baking {
namespace {

/// Relative step of depth between neighbouring pixels that counts as a jump.
constexpr float kJump = 0.02F;
/// The margin shrinks until it leaves this share of the object's pixels.
constexpr double kLeastShare = 0.4;

}  // namespace

VisibleSurface::VisibleSurface(const Mesh& mesh, const Camera& camera)
    : camera_(camera), renderer_(mesh, camera.width, camera.height) {
  camera.validate();
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& p : mesh.positions) {
    box.extend(p.cast<double>());
  }
  low_ = box.min();
  high_ = box.max();
}

void VisibleSurface::find_region(const Pose& T_camera_object) {
  const cv::Rect frame(0, 0, camera_.width, camera_.height);
  Eigen::AlignedBox2d pixels;
  region_ = {};
  int behind = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d p_object((corner & 1) != 0 ? high_.x() : low_.x(), (corner & 2) != 0 ? high_.y() : low_.y(),
                                   (corner & 4) != 0 ? high_.z() : low_.z());
    const Eigen::Vector3d p_camera = T_camera_object * p_object;
    if (p_camera.z() <= 1e-6) {
      ++behind;
    } else {
      pixels.extend(camera_.project(p_camera));
    }
  }
  if (behind == 8) {
    return;
  }
  if (behind > 0) {
    region_ = frame;
    return;
  }
  const auto bounded = [](double value, int size) { return std::clamp(value, -2.0, size + 2.0); };
  const cv::Point begin(static_cast<int>(std::floor(bounded(pixels.min().x(), camera_.width))) - 1,
                        static_cast<int>(std::floor(bounded(pixels.min().y(), camera_.height))) - 1);
  const cv::Point end(static_cast<int>(std::ceil(bounded(pixels.max().x(), camera_.width))) + 2,
                      static_cast<int>(std::ceil(bounded(pixels.max().y(), camera_.height))) + 2);
  region_ = cv::Rect(begin, end) & frame;
}

void VisibleSurface::draw(const Pose& T_camera_object, int margin) {
  find_region(T_camera_object);
  if (region_.empty()) {
    region_ = {};
    return;
  }
  depth_.create(region_.size(), CV_32F);
  const DepthRange range =
      renderer_.render(T_camera_object, camera_, {region_.x, region_.y, region_.width, region_.height},
                       {nullptr, depth_.ptr<float>(), 0});
  const auto n = static_cast<float>(range.near_plane);
  const auto f = static_cast<float>(range.far_plane);
  for (int y = 0; y < depth_.rows; ++y) {
    auto* row = depth_.ptr<float>(y);
    for (int x = 0; x < depth_.cols; ++x) {
      row[x] = row[x] < 1.0F ? n * f / (f - row[x] * (f - n)) : 0.0F;
    }
  }

  // Steps to the right and downwards; a step from or to nothing is a jump.
  slope_ = cv::Mat::zeros(region_.size(), CV_32F);
  cv::Mat smooth = cv::Mat::zeros(region_.size(), CV_8U);
  const int right_border = camera_.width - 1 - region_.x;
  const int lower_border = camera_.height - 1 - region_.y;
  for (int y = 0; y < depth_.rows; ++y) {
    for (int x = 0; x < depth_.cols; ++x) {
      const float z = depth_.at<float>(y, x);
      if (z <= 0) {
        continue;
      }
      float steepest = 0;
      bool jump = false;
      for (const cv::Point& step : {cv::Point(1, 0), cv::Point(-1, 0), cv::Point(0, 1), cv::Point(0, -1)}) {
        const cv::Point other(x + step.x, y + step.y);
        // Beyond the frame there is no telling; its border has the margin too.
        const bool outside =
            other.x < -region_.x || other.y < -region_.y || other.x > right_border || other.y > lower_border;
        const bool inside = other.x >= 0 && other.y >= 0 && other.x < depth_.cols && other.y < depth_.rows;
        const float z_other = inside ? depth_.at<float>(other) : 0.0F;
        if (outside || z_other <= 0 || std::abs(z_other - z) > kJump * z) {
          jump = true;
        } else {
          steepest = std::max(steepest, std::abs(z_other - z));
        }
      }
      slope_.at<float>(y, x) = steepest;
      smooth.at<std::uint8_t>(y, x) = jump ? 0 : 255;
    }
  }
  // The pixels next to a jump are out already; each further pixel of the margin is one erosion.
  const double all = cv::countNonZero(depth_ > 0);
  safe_ = smooth;
  for (int i = 1; i < margin; ++i) {
    cv::Mat eroded;
    cv::erode(safe_, eroded, {}, {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
    if (cv::countNonZero(eroded) < kLeastShare * all) {
      break;
    }
    safe_ = eroded;
  }
}

}  // namespace holdfast::baking
