#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "holdfast/detection.hpp"
#include "holdfast/device.hpp"
#include "holdfast/tracker.hpp"

namespace holdfast::app {

/// The model's features, from the file `views`, where they are kept if one is given, else from the cache folder, where
/// a file that cannot be used or written only costs making them again. Throws as detection::ModelFeatures.
detection::ModelFeatures kept_features(const Mesh& mesh, const std::filesystem::path& views,
                                       const DeviceOptions& options);

/// Looks for an object that is not followed: until it is found for the first time in every frame, after a loss in every
/// second one from the second on.
class ObjectSearch {
 public:
  using Propose = std::function<std::vector<detection::PoseCandidate>(const ImageView& frame)>;

  /// Proposes poses from which the tracker may start.
  explicit ObjectSearch(Propose propose) : propose_(std::move(propose)) {}

  /// The frame's result: held, and the tracker goes on from there, or lost, not found yet.
  FrameResult start(Tracker& tracker, const ImageView& frame, double time_s);
  /// After the tracker has looked at a frame: where it has lost the object, `result` is what is found without it.
  void follow(Tracker& tracker, const ImageView& frame, double time_s, FrameResult& result);

 private:
  std::optional<FrameResult> look(Tracker& tracker, const ImageView& frame, double time_s);

  Propose propose_;
  double ms_ = 0;          ///< that the last look took
  std::int64_t lost_ = 0;  ///< frames in a row
};

}  // namespace holdfast::app
