#include "evaluation/occluder_use.hpp"

#include <fmt/core.h>

#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "holdfast/error.hpp"

namespace holdfast::evaluation {

OccluderUse occluder_use(const PixelMask& decisions, const cv::Mat& occluder) {
  if (occluder.cols != decisions.width || occluder.rows != decisions.height) {
    throw Error(ErrorCode::image, fmt::format("an occluder's mask of {}x{} pixels for frames of {}x{}", occluder.cols,
                                              occluder.rows, decisions.width, decisions.height));
  }
  OccluderUse out;
  for (int y = 0; y < decisions.height; ++y) {
    const std::uint8_t* covered = occluder.ptr<std::uint8_t>(y);
    const std::uint8_t* classes = decisions.classes.data() + static_cast<std::size_t>(y) * decisions.width;
    for (int x = 0; x < decisions.width; ++x) {
      const auto pixel = static_cast<PixelClass>(classes[x]);
      const bool on_occluder = covered[x] >= 128 && pixel != PixelClass::not_visible;
      out.overlaps = out.overlaps || on_occluder;
      if (pixel == PixelClass::used) {
        ++out.used;
        out.on_occluder += on_occluder ? 1 : 0;
      }
    }
  }
  return out;
}

cv::Mat load_occluder_mask(const std::filesystem::path& path, const Camera& camera) {
  const cv::Mat recorded = cv::imread(path.string(), cv::IMREAD_GRAYSCALE);
  if (recorded.empty()) {
    throw Error(ErrorCode::file, fmt::format("{}: not a readable image", path.string()));
  }
  if (!camera.has_distortion()) {
    return recorded;
  }
  cv::Mat map(camera.height, camera.width, CV_32FC2);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Eigen::Vector2d at = camera.distort({x, y});
      map.at<cv::Vec2f>(y, x) = cv::Vec2f(static_cast<float>(at.x()), static_cast<float>(at.y()));
    }
  }
  cv::Mat straight;
  cv::remap(recorded, straight, map, cv::noArray(), cv::INTER_LINEAR);
  return straight;
}

}  // namespace holdfast::evaluation
