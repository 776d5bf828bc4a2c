#include "detection/frame_mat.hpp"

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>

#include "holdfast/error.hpp"

namespace holdfast::detection {
namespace {

cv::Mat bytes_of(const ImageView& frame, int channels) {
  const std::size_t stride = frame.stride_bytes > 0 ? frame.stride_bytes : packed_stride(frame.format, frame.width);
  return cv::Mat(frame.height, frame.width, CV_8UC(channels), const_cast<std::uint8_t*>(frame.data), stride);
}

}  // namespace

cv::Mat grey_of(const ImageView& frame) {
  cv::Mat grey;
  switch (frame.format) {
    case PixelFormat::bgr8:
      cv::cvtColor(bytes_of(frame, 3), grey, cv::COLOR_BGR2GRAY);
      break;
    case PixelFormat::rgb8:
      cv::cvtColor(bytes_of(frame, 3), grey, cv::COLOR_RGB2GRAY);
      break;
    case PixelFormat::rgba8:
      cv::cvtColor(bytes_of(frame, 4), grey, cv::COLOR_RGBA2GRAY);
      break;
    case PixelFormat::bgra8:
      cv::cvtColor(bytes_of(frame, 4), grey, cv::COLOR_BGRA2GRAY);
      break;
    case PixelFormat::grey8:
    case PixelFormat::nv12:
      grey = bytes_of(frame, 1);
      break;
    case PixelFormat::yuyv:
      cv::extractChannel(bytes_of(frame, 2), grey, 0);
      break;
  }
  return grey;
}

cv::Mat channels_of(const ImageView& frame) {
  switch (frame.format) {
    case PixelFormat::bgr8:
    case PixelFormat::rgb8:
      return bytes_of(frame, 3);
    case PixelFormat::rgba8:
    case PixelFormat::bgra8: {
      cv::Mat colors;
      cv::cvtColor(bytes_of(frame, 4), colors, cv::COLOR_RGBA2RGB);  // drops alpha, in either order
      return colors;
    }
    default:
      return grey_of(frame);
  }
}

void require_size(const ImageView& frame, const Camera& camera) {
  if (frame.data != nullptr && frame.width == camera.width && frame.height == camera.height) return;
  throw Error(ErrorCode::image, "a frame of " + std::to_string(frame.width) + "x" + std::to_string(frame.height) +
                                    " pixels where the camera has " + std::to_string(camera.width) + "x" +
                                    std::to_string(camera.height));
}

void undistort(const Camera& camera, std::vector<cv::Point2f>& pixels) {
  if (!camera.has_distortion() || pixels.empty()) return;
  const bool fisheye = camera.lens == LensModel::fisheye;
  const cv::Mat K = (cv::Mat_<double>(3, 3) << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  const cv::Mat distortion(1, fisheye ? 4 : 8, CV_64F, const_cast<double*>(camera.distortion.data()));
  std::vector<cv::Point2f> straight;
  if (fisheye) {
    cv::fisheye::undistortPoints(pixels, straight, K, distortion, cv::noArray(), K);
  } else {
    cv::undistortPoints(pixels, straight, K, distortion, cv::noArray(), K);
  }
  pixels = std::move(straight);
}

}  // namespace holdfast::detection
