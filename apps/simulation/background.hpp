#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>

/// What is seen behind the objects.
namespace holdfast::simulation {

/// A cluttered scene made of overlapping shaded things of every size (a dead-leaves picture: edges and gradients at all
/// scales, as photographs have them). BGR8; the same for the same size and seed.
cv::Mat procedural_picture(cv::Size size, std::uint64_t seed);

struct BackgroundOptions {
  std::filesystem::path
      file;        ///< a picture or a video (one frame a frame, from the start again at its end); empty: made
  double pan = 0;  ///< pixels a frame that the background moves by, along a slow figure of eight
};

class Background {
 public:
  /// Throws Error(file) when the picture or video cannot be read.
  Background(const BackgroundOptions& options, cv::Size frame_size, std::uint64_t seed);
  ~Background();

  /// CV_32FC3 of the frame's size: linear BGR at a time in frames. Safe to call from several threads.
  cv::Mat at(double frame) const;

 private:
  struct Video;
  cv::Mat picture(int frame) const;

  cv::Size size_;
  double pan_;
  int margin_ = 0;    // pixels of the picture beyond the frame on each side, so that it can move
  double phase_ = 0;  // of the figure of eight
  cv::Mat still_;     // linear, frame and margin
  std::unique_ptr<Video> video_;
};

/// Linear light (CV_32FC3) of an encoded picture (CV_8UC3).
cv::Mat linear_from_encoded(const cv::Mat& picture);

}  // namespace holdfast::simulation
