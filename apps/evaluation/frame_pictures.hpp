#pragma once

#include <filesystem>
#include <vector>

#include "evaluation/protocol.hpp"
#include "evaluation/sequence.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/tracker.hpp"
#include "track/overlay.hpp"

namespace holdfast::evaluation {

/// Pictures of chosen frames as `holdfast track --overlay` draws them: outline, and what became of each pixel.
class FramePictures {
 public:
  /// Files go to `folder` as NAME_stepN_FRAME.png. All arguments but `folder` and `frames` must outlive this.
  /// Throws Error(renderer, model).
  FramePictures(const Mesh& mesh, const Sequence& sequence, const Tracker& tracker, std::filesystem::path folder,
                std::vector<int> frames);

  /// Draws the frame just tracked when it is one of those chosen. Throws Error(output) where it cannot be written.
  void draw(const FrameRecord& record);

 private:
  const Sequence& sequence_;
  const Tracker& tracker_;
  app::Overlay overlay_;
  std::filesystem::path folder_;
  std::vector<int> frames_;
};

}  // namespace holdfast::evaluation
