#include "support/simulated.hpp"

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

ImageView view_of(const cv::Mat& image, PixelFormat format) {
  return {image.data, image.cols, format == PixelFormat::nv12 ? image.rows * 2 / 3 : image.rows, image.step, format};
}

}  // namespace holdfast::test
