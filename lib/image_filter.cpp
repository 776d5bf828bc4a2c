#include "image_filter.hpp"

#include <cmath>

namespace holdfast {

std::vector<float> ImageFilter::gaussian_taps(double sigma) {
  if (sigma <= 0) return {1.0f};
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  std::vector<double> weights;
  double sum = 0;
  for (int k = 0; k <= radius; ++k) {
    weights.push_back(std::exp(-0.5 * k * k / (sigma * sigma)));
    sum += (k == 0 ? 1 : 2) * weights.back();
  }
  std::vector<float> taps;
  for (const double weight : weights) taps.push_back(static_cast<float>(weight / sum));
  return taps;
}

ImageFilter::ImageFilter(const Device::Impl& device, double sigma, const std::vector<Level>& levels) : device_(device) {
  auto taps = gaussian_taps(sigma);
  radius_ = static_cast<int>(taps.size()) - 1;
  if (radius_ > HF_MAX_RADIUS) {
    throw Error(ErrorCode::invalid_argument,
                "blur_sigma " + std::to_string(sigma) + " is too wide: its reach of " + std::to_string(radius_) +
                    " pixels exceeds " + std::to_string(HF_MAX_RADIUS) + "; use a coarser finest_level instead");
  }
  taps_ = cl::Buffer(device.context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, taps.size() * sizeof(float), taps.data());
  const std::size_t bytes = (levels[0].elements * HF_PIXEL + kGuardFloats) * sizeof(float);
  scratch_ = device.zeroed_buffer(bytes);
  blurred_ = device.zeroed_buffer(bytes);
  halve_ = device.kernel("halve");
  blur_rows_ = device.kernel("blur_rows");
  blur_columns_ = device.kernel("blur_columns");
  features_ = device.kernel("image_features");
}

void ImageFilter::enqueue_halve(const cl::Buffer& in, const Level& in_level, const Rect& rect, const Level& out_level,
                                const cl::Buffer& out) {
  halve_.setArg(0, in);
  halve_.setArg(1, in_level.layout);
  halve_.setArg(2, to_kernel(rect));
  halve_.setArg(3, out_level.layout);
  halve_.setArg(4, out);
  device_.enqueue_rows(halve_, rect.width, rect.height);
}

const cl::Buffer& ImageFilter::enqueue_blur(const cl::Buffer& in, const Level& level, const Rect& rect) {
  const auto enqueue = [&](cl::Kernel& kernel, const cl::Buffer& from, const cl::Buffer& to, const Rect& area) {
    kernel.setArg(0, from);
    kernel.setArg(1, level.layout);
    kernel.setArg(2, to_kernel(area));
    kernel.setArg(3, taps_);
    kernel.setArg(4, radius_);
    kernel.setArg(5, to);
    device_.enqueue_rows(kernel, area.width, area.height);
  };
  // The columns' pass reads rows above and below: at the image's border too they must be of this image (zero), not what
  // another level or the other image left in the scratch memory.
  enqueue(blur_rows_, in, scratch_, {rect.x, rect.y - radius_, rect.width, rect.height + 2 * radius_});
  enqueue(blur_columns_, scratch_, blurred_, rect);
  return blurred_;
}

void ImageFilter::enqueue_features(const cl::Buffer& in, const Level& level, const Rect& rect, const cl::Buffer& out) {
  features_.setArg(0, in);
  features_.setArg(1, level.layout);
  features_.setArg(2, to_kernel(rect));
  features_.setArg(3, out);
  device_.enqueue_rows(features_, rect.width, rect.height);
}

}  // namespace holdfast
