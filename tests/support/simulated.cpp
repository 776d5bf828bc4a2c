#include "support/simulated.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace holdfast::test {

simulation::SequenceOptions noisy_box(int frames, std::uint64_t seed, double nearest, double farthest) {
  simulation::SequenceOptions options;
  options.camera = {512, 384, 600, 600, 255.5, 191.5, {}};
  options.frames = frames;
  options.seed = seed;
  options.motion.nearest = nearest;
  options.motion.farthest = farthest;
  options.sensor.noise = 2;
  return options;
}

std::vector<cv::Mat> frames_of(const simulation::Sequence& sequence) {
  std::vector<cv::Mat> frames;
  for (int i = 0; i < sequence.size(); ++i) frames.push_back(sequence.frame(i));
  return frames;
}

ImageView view_of(const cv::Mat& image, PixelFormat format) {
  return {image.data, image.cols, format == PixelFormat::nv12 ? image.rows * 2 / 3 : image.rows, image.step, format};
}

cv::Mat clutter(const Camera& camera) {
  cv::Mat picture(camera.height, camera.width, CV_8UC3);
  cv::RNG(5).fill(picture, cv::RNG::UNIFORM, 0, 255);
  cv::GaussianBlur(picture, picture, {}, 2);
  return picture;
}

double median_mm(Tracker& tracker, const std::vector<Pose>& poses, const std::vector<cv::Mat>& frames,
                 std::size_t from) {
  tracker.reset(poses[0]);
  std::vector<double> errors;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const FrameResult result = tracker.track(view_of(frames[i]));
    CHECK(result.status == Status::held);
    if (i >= from) errors.push_back(1e3 * (poses[i].translation() - result.T_camera_object.translation()).norm());
  }
  const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
  std::nth_element(errors.begin(), middle, errors.end());
  return *middle;
}

}  // namespace holdfast::test
