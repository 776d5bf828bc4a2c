#include <algorithm>
#include <cmath>

#include "detection/focal_fit.hpp"
#include "detection/frame_mat.hpp"
#include "detection/matcher.hpp"
#include "detection/robust_pnp.hpp"
#include "holdfast/camera.hpp"

namespace holdfast::detection {
namespace {

/// Focal lengths to begin with, in widths of the frame: from wide lenses to long ones.
constexpr double kShortest = 0.5, kLongest = 3, kNext = 1.3;
constexpr std::size_t kLeastFrames = 3;
constexpr int kRounds = 3;
/// Parts of the frames that are left out in turn, and frames that a part has at least.
constexpr std::size_t kParts = 5, kLeastOfPart = 2;

}  // namespace

struct FocalEstimator::Impl {
  Impl(const ModelFeatures& features, int width, int height)
      : camera{width, height, 1, 1, 0.5 * (width - 1), 0.5 * (height - 1), {}},
        matcher(features),
        radius(features.data().radius) {
    camera.validate();
  }

  cv::Mat matrix(double focal) const {
    return (cv::Mat_<double>(3, 3) << focal, 0, camera.cx, 0, focal, camera.cy, 0, 0, 1);
  }

  std::vector<Consensus> agreeing(double focal) const {
    std::vector<Consensus> seen;
    for (Matches matches : frames) {
      if (std::optional<Consensus> consensus = take_consensus(matches, matrix(focal)))
        seen.push_back(std::move(*consensus));
    }
    return seen;
  }

  /// Variance of the logarithm by what leaving parts of the frames out changes: what is wrong in a view alike (the
  /// model, its texture) shows there. 0 where there are too few frames.
  double variance_of_parts(const std::vector<Consensus>& seen, const FocalFit& whole) const {
    const std::size_t parts = std::min(kParts, seen.size() / kLeastOfPart);
    if (parts < 2) return 0;
    std::vector<double> estimates;
    double mean = 0, square = 0;
    for (std::size_t i = 0; i < parts; ++i) {
      const auto at = [&](std::size_t part) { return static_cast<std::ptrdiff_t>(part * seen.size() / parts); };
      std::vector<Consensus> rest(seen.begin(), seen.begin() + at(i));
      rest.insert(rest.end(), seen.begin() + at(i + 1), seen.end());
      FocalFit fit = whole;
      fit.fit(rest);
      estimates.push_back(std::log(fit.focal()));
      mean += estimates.back() / static_cast<double>(parts);
    }
    for (const double estimate : estimates) square += (estimate - mean) * (estimate - mean);
    return square * static_cast<double>(parts - 1) / static_cast<double>(parts);
  }

  Camera camera;
  Matcher matcher;
  double radius;
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
  if (seen.size() < kLeastFrames) return {};
  FocalFit fit(focal, {impl_->camera.cx, impl_->camera.cy}, width, impl_->radius);
  for (int round = 1; round < kRounds; ++round) {
    fit.fit(seen);
    seen = impl_->agreeing(fit.focal());
    if (seen.size() < kLeastFrames) return {};
  }
  fit.fit(seen);
  const double variance = std::max(fit.variance(), impl_->variance_of_parts(seen, fit));
  return FocalEstimate{fit.focal(), std::sqrt(variance) * fit.focal(), static_cast<int>(seen.size())};
}

}  // namespace holdfast::detection
