#include "init/mirrored_points.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <utility>

#include "holdfast/error.hpp"
#include "init/pose_from_points.hpp"

namespace holdfast::app {
namespace {

/// Pixels that marks are off at least where a mirror image is looked for, and times that it fits better.
constexpr double kLeastRms = 1, kClearly = 3;
/// Pairs below which a mirror image may fit better by chance.
constexpr std::size_t kLeastPairs = 6;

}  // namespace

std::optional<std::string> mirrored_points(const std::vector<PointPair>& pairs, const Camera& camera, double rms) {
  if (rms < kLeastRms || pairs.size() < kLeastPairs) return std::nullopt;
  std::vector<PointPair> exchanged = pairs, negated = pairs;
  for (PointPair& pair : exchanged) std::swap(pair.pixel.x(), pair.pixel.y());
  for (PointPair& pair : negated) pair.p_object.x() *= -1;
  double best = rms / kClearly;
  std::optional<std::string> said;
  const auto look = [&](const std::vector<PointPair>& read, const char* reading) {
    try {
      const PoseFromPoints found = pose_from_points(read, camera);
      if (found.pairs.size() < pairs.size() || found.rms >= best) return;
      best = found.rms;
      said = fmt::format("the points fit to {:.2f} px, but to {:.2f} px {}", rms, found.rms, reading);
    } catch (const Error&) {  // no pose at all
    }
  };
  look(exchanged, "with the pixels' u and v exchanged: are they rows and columns? u goes right, v down");
  look(negated, "with one of the model's axes negated: are the points of a mirrored model?");
  return said;
}

}  // namespace holdfast::app
