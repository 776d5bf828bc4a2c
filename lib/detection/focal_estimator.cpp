#include <algorithm>
#include <cmath>

#include "detection/frame_mat.hpp"
#include "detection/matcher.hpp"
#include "detection/robust_pnp.hpp"
#include "holdfast/camera.hpp"

namespace holdfast::detection {
namespace {

/// Focal lengths to begin with, in widths of the frame: from wide lenses to long ones.
constexpr double kShortest = 0.5, kLongest = 3, kNext = 1.3;
constexpr int kLeastFrames = 3;
constexpr int kRounds = 2, kHalvings = 24;
/// Shares of the focal length over which the curvature is measured.
constexpr double kStep = 0.02;
/// Matches that say the same: features of all sizes overlap.
constexpr double kRepeated = 4;
/// Parts of the frames that are compared, and frames that a part has at least.
constexpr std::size_t kParts = 5, kLeastOfPart = 2;
/// What lens distortion that is not known does to it at least, share.
constexpr double kLeastSigma = 0.01;

}  // namespace

struct FocalEstimator::Impl {
  Impl(const ModelFeatures& features, int width, int height)
      : camera{width, height, 1, 1, 0.5 * (width - 1), 0.5 * (height - 1), {}}, matcher(features) {
    camera.validate();
  }

  cv::Mat matrix(double focal) const {
    return (cv::Mat_<double>(3, 3) << focal, 0, camera.cx, 0, focal, camera.cy, 0, 0, 1);
  }

  /// Sum of the squared distances, pixels, of all that agrees when poses fit best; poses are moved there.
  double cost(std::vector<Consensus>& seen, double focal) const {
    const cv::Mat K = matrix(focal);
    double sum = 0;
    for (Consensus& frame : seen) {
      const PoseFit fit = refined_pose(frame.places, frame.pixels, K, frame.T_camera_object);
      frame.T_camera_object = fit.T_camera_object;
      sum += fit.pixels * fit.pixels * static_cast<double>(frame.places.size());
    }
    return sum;
  }

  std::vector<Consensus> agreeing(double focal) const {
    std::vector<Consensus> seen;
    for (Matches matches : frames) {
      if (std::optional<Consensus> consensus = take_consensus(matches, matrix(focal)))
        seen.push_back(std::move(*consensus));
    }
    return seen;
  }

  /// The focal length of least cost, by golden section of its logarithm.
  double best_focal(std::vector<Consensus>& seen, double least, double most) const {
    const double golden = 0.5 * (std::sqrt(5.0) - 1);
    double a = std::log(least), b = std::log(most);
    double x = b - golden * (b - a), y = a + golden * (b - a);
    double at_x = cost(seen, std::exp(x)), at_y = cost(seen, std::exp(y));
    for (int i = 0; i < kHalvings; ++i) {
      if (at_x < at_y) {
        b = y;
        y = x;
        at_y = at_x;
        x = b - golden * (b - a);
        at_x = cost(seen, std::exp(x));
      } else {
        a = x;
        x = y;
        at_x = at_y;
        y = a + golden * (b - a);
        at_y = cost(seen, std::exp(y));
      }
    }
    return std::exp(0.5 * (a + b));
  }

  /// Variance of the mean of what parts of the frames give alone: what is wrong in a view alike (the model, its
  /// texture) shows there. 0 where there are too few frames.
  double variance_of_parts(const std::vector<Consensus>& seen, double focal) const {
    const std::size_t parts = std::min(kParts, seen.size() / kLeastOfPart);
    if (parts < 2) return 0;
    std::vector<double> estimates;
    for (std::size_t i = 0; i < parts; ++i) {
      const auto at = [&](std::size_t part) {
        return seen.begin() + static_cast<std::ptrdiff_t>(part * seen.size() / parts);
      };
      std::vector<Consensus> part(at(i), at(i + 1));
      estimates.push_back(best_focal(part, 0.8 * focal, focal / 0.8));
    }
    double mean = 0, square = 0;
    for (const double estimate : estimates) mean += estimate / static_cast<double>(parts);
    for (const double estimate : estimates) square += (estimate - mean) * (estimate - mean);
    return square / static_cast<double>(parts * (parts - 1));
  }

  Camera camera;
  Matcher matcher;
  std::vector<Matches> frames;
};

FocalEstimator::FocalEstimator(const ModelFeatures& features, int width, int height)
    : impl_(std::make_unique<Impl>(features, width, height)) {}
FocalEstimator::~FocalEstimator() = default;
FocalEstimator::FocalEstimator(FocalEstimator&&) noexcept = default;
FocalEstimator& FocalEstimator::operator=(FocalEstimator&&) noexcept = default;

bool FocalEstimator::add(const ImageView& frame) {
  require_size(frame, impl_->camera);
  Matches matches = impl_->matcher.match(frame);
  Matches tried = matches;
  if (!take_consensus(tried, impl_->matrix(impl_->camera.width))) return false;
  impl_->frames.push_back(std::move(matches));
  return true;
}

std::optional<FocalEstimate> FocalEstimator::estimate() const {
  if (impl_->frames.size() < kLeastFrames) return {};
  const double width = impl_->camera.width;
  std::vector<Consensus> seen;
  double focal = 0;
  std::size_t most = 0;
  for (double tried = kShortest * width; tried <= kLongest * width; tried *= kNext) {
    std::vector<Consensus> agreeing = impl_->agreeing(tried);
    std::size_t count = 0;
    for (const Consensus& frame : agreeing) count += frame.places.size();
    if (count <= most) continue;
    most = count;
    focal = tried;
    seen = std::move(agreeing);
  }
  for (int round = 0; round < kRounds && !seen.empty(); ++round) {
    focal = impl_->best_focal(seen, 0.6 * focal, focal / 0.6);
    seen = impl_->agreeing(focal);
  }
  if (seen.size() < kLeastFrames) return {};
  focal = impl_->best_focal(seen, 0.8 * focal, focal / 0.8);
  double rows = -1;
  for (const Consensus& frame : seen) rows += 2 * static_cast<double>(frame.places.size()) - 6;
  const double here = impl_->cost(seen, focal), step = kStep * focal;
  const double above = impl_->cost(seen, focal + step), below = impl_->cost(seen, focal - step);
  const double curvature = std::max((above - 2 * here + below) / (step * step), 1e-12);
  const double variance =
      std::max(2 * kRepeated * here / std::max(1.0, rows) / curvature, impl_->variance_of_parts(seen, focal));
  return FocalEstimate{focal, std::hypot(std::sqrt(variance), kLeastSigma * focal), static_cast<int>(seen.size())};
}

}  // namespace holdfast::detection
