#include "detection/matcher.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>

#include "detection/frame_mat.hpp"
#include "holdfast/error.hpp"

namespace holdfast::detection {
namespace {

/// Larger frames are looked at as if they had so many pixels.
constexpr double kMostPixels = 640 * 480;
constexpr int kMostFeatures = 2000;
/// Nearest features of the model that are asked for, and how many leaves of the trees are looked at for them.
constexpr int kNeighbours = 6, kChecks = 48, kTrees = 4;
/// The nearest one must be nearer than this share of the nearest one elsewhere on the model: farther than this share of
/// its radius, since views of the same place repeat each other.
constexpr float kRatio = 0.9f;
constexpr double kElsewhere = 0.08;

struct Match {
  float ratio;
  int feature, place;
};

const ModelFeatures& enough(const ModelFeatures& model) {
  if (model.count() >= static_cast<std::size_t>(kNeighbours)) return model;
  throw Error(ErrorCode::model, "the model has next to no features to recognize it by (" +
                                    std::to_string(model.count()) +
                                    "): read its texture, or learn some from frames first");
}

}  // namespace

Matcher::Matcher(const ModelFeatures& model)
    : model_(enough(model)),
      descriptors_(comparable(model.data().descriptors)),
      trees_(descriptors_, cv::flann::KDTreeIndexParams(kTrees)) {}

Matches Matcher::match(const ImageView& frame) {
  cv::Mat grey = grey_of(frame);
  Matches matches;
  matches.pixel_scale = std::max(1.0, std::sqrt(static_cast<double>(grey.total()) / kMostPixels));
  if (matches.pixel_scale > 1) {
    cv::Mat smaller;
    cv::resize(grey, smaller, {}, 1 / matches.pixel_scale, 1 / matches.pixel_scale, cv::INTER_AREA);
    grey = smaller;
  }
  const PictureFeatures found = features_of(grey, kMostFeatures);
  if (found.places.empty()) return matches;
  const cv::Mat query = comparable(found.descriptors);
  cv::Mat indices(query.rows, kNeighbours, CV_32S), squares(query.rows, kNeighbours, CV_32F);
  trees_.knnSearch(query, indices, squares, kNeighbours, cv::flann::SearchParams(kChecks));
  std::vector<Match> kept;
  const auto& places = model_.data().p_object;
  const double apart = kElsewhere * model_.data().radius;
  for (int i = 0; i < query.rows; ++i) {
    const int* nearest = indices.ptr<int>(i);
    const float* square = squares.ptr<float>(i);
    const Eigen::Vector3f& place = places[static_cast<std::size_t>(nearest[0])];
    int other = 1;
    while (other < kNeighbours - 1 &&
           (places[static_cast<std::size_t>(nearest[other])] - place).cast<double>().norm() < apart) {
      ++other;
    }
    const float ratio = std::sqrt(square[0] / std::max(square[other], 1e-12f));
    if (ratio < kRatio) kept.push_back({ratio, i, nearest[0]});
  }
  std::ranges::sort(kept, {}, [](const Match& match) { return std::pair(match.ratio, match.feature); });
  for (const Match& match : kept) {
    const Eigen::Vector3f& p = places[static_cast<std::size_t>(match.place)];
    matches.places.emplace_back(p.x(), p.y(), p.z());
    const cv::Point2f pixel = found.places[static_cast<std::size_t>(match.feature)].pt;
    const auto to_frame = [&](float value) { return static_cast<float>((value + 0.5) * matches.pixel_scale - 0.5); };
    matches.pixels.emplace_back(to_frame(pixel.x), to_frame(pixel.y));
  }
  return matches;
}

}  // namespace holdfast::detection
