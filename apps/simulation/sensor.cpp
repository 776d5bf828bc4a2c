#include "simulation/sensor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <string>

#include "holdfast/error.hpp"
#include "simulation/light_encoding.hpp"
#include "simulation/random.hpp"

namespace holdfast::simulation {
namespace {

constexpr int curve_steps = 16384;
constexpr int normal_bits = 12;

// The value below which the standard normal distribution has the given share (by bisection: made once, 4096 values).
double normal_quantile(double share) {
  double low = -8, high = 8;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (0.5 * std::erfc(-middle / std::numbers::sqrt2) < share ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

Sensor::Sensor(const SensorOptions& options, std::uint64_t seed) : options_(options), seed_(hash(seed, 0x5e50)) {
  const auto check = [](bool fine, const char* what) {
    if (!fine) throw Error(ErrorCode::invalid_argument, std::string("sensor: ") + what);
  };
  check(options.blur_sigma >= 0 && options.blur_sigma <= 50, "the blur must be 0 to 50 pixels");
  check(options.noise >= 0 && options.shot_noise >= 0, "noise must not be negative");
  check(options.gain > 0, "the gain must be positive");
  check(options.change_frames > 0, "changes must take a positive number of frames");
  check(options.jpeg_quality >= 0 && options.jpeg_quality <= 100, "the JPEG quality must be 1 to 100, or 0 for none");
  encoded_.resize(curve_steps + 1);
  for (int i = 0; i <= curve_steps; ++i) {
    encoded_[static_cast<std::size_t>(i)] =
        static_cast<float>(255.0 * encoded_from_linear(static_cast<double>(i) / curve_steps));
  }
  if (options.noise > 0 || options.shot_noise > 0) {
    constexpr int count = 1 << normal_bits;
    for (int i = 0; i < count; ++i) normal_.push_back(static_cast<float>(normal_quantile((i + 0.5) / count)));
  }
}

cv::Mat Sensor::record(const cv::Mat& light, int frame) const {
  cv::Mat blurred = light;
  if (options_.blur_sigma > 0) cv::GaussianBlur(light, blurred, {}, options_.blur_sigma);

  const double phase = 2.0 * std::numbers::pi * frame / options_.change_frames;
  const double exposure = options_.gain * std::exp2(options_.exposure_stops * std::sin(phase));
  const double balance = std::exp2(options_.white_balance_stops * std::sin(0.7 * phase));
  const double exponent = std::exp2(options_.gamma_stops * std::sin(1.3 * phase));
  const std::array<float, 3> gain = {static_cast<float>(exposure / balance * curve_steps),
                                     static_cast<float>(exposure * curve_steps),
                                     static_cast<float>(exposure * balance * curve_steps)};
  std::vector<float> curve = encoded_;
  if (exponent != 1.0) {
    for (float& value : curve) value = static_cast<float>(255.0 * std::pow(value / 255.0, exponent));
  }

  cv::Mat result(light.size(), CV_8UC3);
  const bool noisy = !normal_.empty();
  const float variance = static_cast<float>(options_.noise * options_.noise);
  const float variance_slope = static_cast<float>(options_.shot_noise * options_.shot_noise / 255.0);
  for (int y = 0; y < light.rows; ++y) {
    const float* in = blurred.ptr<float>(y);
    std::uint8_t* out = result.ptr<std::uint8_t>(y);
    for (int x = 0; x < light.cols; ++x, in += 3, out += 3) {
      // One draw a pixel holds the three channels' noise.
      std::uint64_t bits = noisy ? hash(seed_, static_cast<std::uint64_t>(frame),
                                        static_cast<std::uint64_t>(y) << 32 | static_cast<std::uint32_t>(x))
                                 : 0;
      for (int k = 0; k < 3; ++k) {
        const float scaled =
            std::clamp(in[k] * gain[static_cast<std::size_t>(k)], 0.0f, static_cast<float>(curve_steps));
        float value = curve[static_cast<std::size_t>(scaled + 0.5f)];
        if (noisy) {
          value += normal_[bits & ((1U << normal_bits) - 1)] * std::sqrt(variance + variance_slope * value);
          bits >>= normal_bits;
        }
        out[k] = static_cast<std::uint8_t>(std::clamp(value + 0.5f, 0.0f, 255.0f));
      }
    }
  }
  return result;
}

}  // namespace holdfast::simulation
