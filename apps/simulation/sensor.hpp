#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

/// What a camera makes of the light that falls on it.
namespace holdfast::simulation {

struct SensorOptions {
  double blur_sigma = 0;           ///< of the lens, pixels
  double noise = 0;                ///< standard deviation everywhere, grey levels of 255
  double shot_noise = 0;           ///< further standard deviation at white, grey levels; grows as the root of the light
  double exposure_stops = 0;       ///< the exposure swings by this many stops up and down
  double white_balance_stops = 0;  ///< red and blue swing by this many stops against each other
  double gamma_stops = 0;          ///< the tone curve's exponent swings by this many powers of two
  double change_frames = 100;      ///< frames of one such swing; all start from neutral at frame 0
  double gain = 1.0;               ///< of the exposure, on top
  int jpeg_quality = 0;            ///< 1 to 100; 0: not compressed
};

class Sensor {
 public:
  /// Throws Error(invalid_argument) when an option is out of its range.
  Sensor(const SensorOptions& options, std::uint64_t seed);

  /// The recorded frame (CV_8UC3, BGR) of linear light (CV_32FC3, BGR), before compression.
  cv::Mat record(const cv::Mat& light, int frame) const;

  const SensorOptions& options() const { return options_; }

 private:
  SensorOptions options_;
  std::uint64_t seed_;
  std::vector<float> encoded_;  // grey levels over linear light in [0, 1]
  std::vector<float> normal_;   // evenly spaced quantiles of the standard normal distribution
};

}  // namespace holdfast::simulation
