#pragma once

#include <opencv2/core.hpp>

#include "holdfast/camera.hpp"
#include "simulation/rasterizer.hpp"

namespace holdfast::simulation {

/// Draws scenes as a camera with lens distortion sees them: ideally first, larger than the frame, then bent into shape
/// before samples are averaged to pixels.
class Lens {
 public:
  /// Throws Error(camera) when the distortion cannot be inverted all over the frame.
  explicit Lens(const Camera& camera);

  /// As simulation::draw().
  Layer draw(const Scene& scene, int samples, bool shade = true) const;

 private:
  cv::Mat bend(const cv::Mat& ideal, const cv::Rect& region, int samples) const;

  Camera camera_;
  Camera ideal_;         // without distortion, wide enough for all that the lens gathers
  cv::Mat ideal_pixel_;  // CV_32FC2: the pixel of ideal_ that each pixel shows; one pixel of margin all round
};

}  // namespace holdfast::simulation
