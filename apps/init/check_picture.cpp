#include "init/check_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "holdfast/error.hpp"
#include "init/point_residuals.hpp"
#include "track/output_file.hpp"

namespace holdfast::app {
namespace {

constexpr int kPictureWidth = 1280;  // pixels, at least
constexpr int kSubpixelBits = 4;
constexpr double kBend = 8;  // frame pixels from one bend of a line to the next

const cv::Scalar kOutlineColor(90, 255, 120);
const cv::Scalar kMarkedColor(60, 60, 255);
const cv::Scalar kProjectedColor(60, 230, 255);

cv::Point subpixel(const Eigen::Vector2d& place) {
  constexpr double scale = 1 << kSubpixelBits;
  const auto coordinate = [](double value) {
    return static_cast<int>(std::lround(std::clamp(value, -1e6, 1e6) * scale));
  };
  return {coordinate(place.x()), coordinate(place.y())};
}

}  // namespace

EnlargedFrame::EnlargedFrame(const cv::Mat& frame)
    : factor_(std::max(1, (kPictureWidth + frame.cols - 1) / std::max(frame.cols, 1))) {
  cv::resize(frame, picture_, {}, factor_, factor_, cv::INTER_CUBIC);
}

Eigen::Vector2d EnlargedFrame::to_picture(const Eigen::Vector2d& pixel) const {
  return (pixel.array() + 0.5) * factor_ - 0.5;
}

Eigen::Vector2d EnlargedFrame::to_frame(const Eigen::Vector2d& place) const {
  return (place.array() + 0.5) / factor_ - 0.5;
}

void EnlargedFrame::draw_lines(const std::vector<Line>& lines, const Camera& camera, const cv::Scalar& color) {
  for (const Line& line : lines) {
    const int parts = camera.has_distortion() ? static_cast<int>(std::ceil((line.end - line.begin).norm() / kBend)) : 1;
    std::vector<cv::Point> corners;
    for (int i = 0; i <= std::max(parts, 1); ++i) {
      const Eigen::Vector2d ideal =
          line.begin + (line.end - line.begin) * (static_cast<double>(i) / std::max(parts, 1));
      corners.push_back(subpixel(to_picture(camera.distort(ideal))));
    }
    cv::polylines(picture_, corners, false, color, 1, cv::LINE_AA, kSubpixelBits);
  }
}

void EnlargedFrame::draw_cross(const Eigen::Vector2d& pixel, const cv::Scalar& color) {
  const Eigen::Vector2d place = to_picture(pixel);
  for (const Eigen::Vector2d& arm : {Eigen::Vector2d(7, 0), Eigen::Vector2d(0, 7)}) {
    cv::line(picture_, subpixel(place - arm), subpixel(place + arm), color, 1, cv::LINE_AA, kSubpixelBits);
  }
}

void EnlargedFrame::draw_circle(const Eigen::Vector2d& pixel, const cv::Scalar& color) {
  cv::circle(picture_, subpixel(to_picture(pixel)), 5 << kSubpixelBits, color, 1, cv::LINE_AA, kSubpixelBits);
}

void EnlargedFrame::draw_text(const std::string& text, const Eigen::Vector2d& place, const cv::Scalar& color) {
  const cv::Point origin(static_cast<int>(place.x()), static_cast<int>(place.y()));
  cv::putText(picture_, text, origin, cv::FONT_HERSHEY_SIMPLEX, 0.5, {20, 20, 20}, 3, cv::LINE_AA);
  cv::putText(picture_, text, origin, cv::FONT_HERSHEY_SIMPLEX, 0.5, color, 1, cv::LINE_AA);
}

cv::Mat check_picture(const cv::Mat& frame, const Camera& camera, const Pose& T_camera_object,
                      const std::vector<Line>& outline, const std::vector<PointPair>& pairs) {
  EnlargedFrame enlarged(frame);
  enlarged.draw_lines(outline, camera, kOutlineColor);
  const std::vector<Eigen::Vector2d> residuals = point_residuals(pairs, camera, T_camera_object);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    enlarged.draw_cross(pairs[i].pixel, kMarkedColor);
    if (residuals[i].allFinite()) {
      enlarged.draw_circle(pairs[i].pixel + residuals[i], kProjectedColor);
    }
    enlarged.draw_text(fmt::format("{}", i + 1), enlarged.to_picture(pairs[i].pixel) + Eigen::Vector2d(8, -8),
                       kMarkedColor);
  }
  enlarged.draw_text(fmt::format("rms {:.2f} px over {} points  (red: marked, yellow: as the pose puts them)",
                                 root_mean_square(residuals), pairs.size()),
                     {12, 24}, {255, 255, 255});
  return enlarged.picture();
}

void save_picture(const std::filesystem::path& path, const cv::Mat& picture) {
  std::vector<std::uint8_t> encoded;
  try {
    cv::imencode(path.extension().string(), picture, encoded);
  } catch (const cv::Exception&) {
    encoded.clear();
  }
  if (encoded.empty()) {
    throw Error(ErrorCode::output,
                fmt::format("cannot write '{}': give a picture's name, ending in .png or .jpg", path.string()));
  }
  write_whole(path, {reinterpret_cast<const char*>(encoded.data()), encoded.size()});
}

}  // namespace holdfast::app
