#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "holdfast/image_view.hpp"
#include "holdfast/tracker.hpp"
#include "simulation/sequence.hpp"

namespace holdfast::test {

/// A box between two distances (metres), 512x384, with 2 grey levels of noise.
simulation::SequenceOptions noisy_box(int frames, std::uint64_t seed, double nearest, double farthest);

/// All of a sequence's frames, for those who track them more than once.
std::vector<cv::Mat> frames_of(const simulation::Sequence& sequence);

/// What a tracker reads of a picture of OpenCV's, which must outlive it.
ImageView view_of(const cv::Mat& image, PixelFormat format = PixelFormat::bgr8);

/// A picture of nothing but blurred noise: the object is not in it.
cv::Mat clutter(const Camera& camera);

/// Median distance from the true positions, millimetres, of frames `from` on; all are tracked from the first true pose,
/// and checked to be held.
double median_mm(Tracker& tracker, const std::vector<Pose>& poses, const std::vector<cv::Mat>& frames,
                 std::size_t from);

}  // namespace holdfast::test
