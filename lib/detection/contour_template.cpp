#include "detection/contour_template.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace holdfast::detection {
namespace {

/// Strength of an edge of the view: 1 for the contour, the change of the unit normal for a crease.
constexpr float kSharp = 0.35f;

}  // namespace

EdgePicture edges_of(const cv::Mat& channels) {
  cv::Mat dx, dy;
  cv::Sobel(channels, dx, CV_32F, 1, 0, 3, 0.125);
  cv::Sobel(channels, dy, CV_32F, 0, 1, 3, 0.125);
  const int rows = channels.rows, columns = channels.cols, count = channels.channels();
  cv::Mat all(rows, columns, CV_32F), gx(rows, columns, CV_32F), gy(rows, columns, CV_32F);
  EdgePicture edges{cv::Mat::zeros(rows, columns, CV_32F), cv::Mat::zeros(rows, columns, CV_8U)};
  for (int y = 0; y < rows; ++y) {
    const float *x_row = dx.ptr<float>(y), *y_row = dy.ptr<float>(y);
    for (int x = 0; x < columns; ++x) {
      float best = -1;
      for (int c = 0; c < count; ++c) {
        const float a = x_row[x * count + c], b = y_row[x * count + c], square = a * a + b * b;
        if (square > best) {
          best = square;
          gx.at<float>(y, x) = a;
          gy.at<float>(y, x) = b;
        }
      }
      all.at<float>(y, x) = std::sqrt(best);
    }
  }
  for (int y = 1; y + 1 < rows; ++y) {
    for (int x = 1; x + 1 < columns; ++x) {
      const float strength = all.at<float>(y, x), a = gx.at<float>(y, x), b = gy.at<float>(y, x);
      if (strength <= 0) continue;
      const float steep = 0.4142f;
      const int sx = std::abs(a) > steep * std::abs(b) ? (a > 0 ? 1 : -1) : 0;
      const int sy = std::abs(b) > steep * std::abs(a) ? (b > 0 ? 1 : -1) : 0;
      if (all.at<float>(y + sy, x + sx) > strength || all.at<float>(y - sy, x - sx) >= strength) continue;
      edges.strength.at<float>(y, x) = strength;
      const double turn = std::atan2(b, a) / M_PI * kDirections;
      edges.direction.at<std::uint8_t>(y, x) =
          static_cast<std::uint8_t>((static_cast<int>(std::lround(turn)) + 2 * kDirections) % kDirections);
    }
  }
  return edges;
}

ContourDrawer::ContourDrawer(const Mesh& mesh, const Camera& camera)
    : camera_(camera), renderer_(mesh, camera.width, camera.height), window_(camera.height, camera.width, CV_32F) {}

std::vector<ContourPoint> ContourDrawer::draw(const Pose& T_camera_object, std::size_t most) {
  const Rect whole{0, 0, camera_.width, camera_.height};
  const DepthRange range =
      renderer_.render(T_camera_object, camera_, whole, {nullptr, window_.ptr<float>(), camera_.width});
  // Unit normals where there is surface, four channels with the mask.
  cv::Mat shape = cv::Mat::zeros(camera_.height, camera_.width, CV_32FC4);
  const auto z_at = [&](int y, int x) {
    const float depth = window_.at<float>(y, x);
    return depth < 1 ? range.metric(static_cast<double>(depth)) : 0.0;
  };
  const auto point = [&](int y, int x, double z) {
    return Eigen::Vector3d((x - camera_.cx) / camera_.fx * z, (y - camera_.cy) / camera_.fy * z, z);
  };
  for (int y = 1; y + 1 < camera_.height; ++y) {
    for (int x = 1; x + 1 < camera_.width; ++x) {
      const double z = z_at(y, x);
      if (z <= 0) continue;
      const Eigen::Vector3d p = point(y, x, z);
      const auto slope = [&](int ya, int xa, int yb, int xb) {  // towards the neighbour on the same surface
        const double before = z_at(ya, xa), after = z_at(yb, xb);
        const bool on = after > 0 && (before <= 0 || std::abs(after - z) < std::abs(before - z));
        return on           ? Eigen::Vector3d(point(yb, xb, after) - p)
               : before > 0 ? Eigen::Vector3d(p - point(ya, xa, before))
                            : Eigen::Vector3d(Eigen::Vector3d::Zero());
      };
      const Eigen::Vector3d n = slope(y, x - 1, y, x + 1).cross(slope(y - 1, x, y + 1, x));
      const double length = n.norm();
      cv::Vec4f& value = shape.at<cv::Vec4f>(y, x);
      for (int c = 0; c < 3; ++c) value[c] = length > 0 ? static_cast<float>(0.5 * n(c) / length) : 0;
      value[3] = 2;
    }
  }
  cv::GaussianBlur(shape, shape, {}, 0.8);
  const EdgePicture edges = edges_of(shape);
  std::vector<ContourPoint> all;
  for (int y = 0; y < camera_.height; ++y) {
    for (int x = 0; x < camera_.width; ++x) {
      if (edges.strength.at<float>(y, x) < kSharp * 0.35f) continue;
      all.push_back(
          {static_cast<std::int16_t>(x), static_cast<std::int16_t>(y), edges.direction.at<std::uint8_t>(y, x)});
    }
  }
  const std::size_t count = std::min(all.size(), most);
  std::vector<ContourPoint> chosen;
  for (std::size_t i = 0; i < count; ++i) chosen.push_back(all[i * all.size() / count]);
  return chosen;
}

}  // namespace holdfast::detection
