#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/mesh.hpp"
#include "track/contact_sheet.hpp"
#include "track/overlay.hpp"
#include "track/overlay_video.hpp"
#include "track/pose_writers.hpp"
#include "track/run_summary.hpp"

namespace holdfast::app {

/// Where a run's results go; empty: not written.
struct OutputPaths {
  std::filesystem::path poses;
  std::filesystem::path tum;
  std::filesystem::path json;
  std::filesystem::path overlay;
  std::filesystem::path contact_sheet;
  int contact_frames = 20;

  /// Those that are written.
  std::vector<std::filesystem::path> given() const;
};

/// All files that a run writes; what is not asked for costs nothing.
class RunFiles {
 public:
  /// Creates the files. `frame_rate`: of the overlay; `run`: what was run, a JSON object's text.
  /// Throws Error(output, renderer).
  RunFiles(const OutputPaths& paths, const Mesh& mesh, const Camera& camera, double frame_rate,
           std::optional<std::int64_t> expected_frames, const std::string& run);

  /// True when write() will draw the frame of this ordinal.
  bool is_pictured(std::int64_t ordinal) const;

  /// Every file is complete up to this frame afterwards, but for the video and the contact sheet, which finish() writes
  /// out.
  void write(const TrackedFrame& tracked);

  /// Completes each file, even if another cannot be; throws the first failure.
  void finish(const RunSummary& summary);

  /// Those that finish() could not complete.
  const std::vector<std::filesystem::path>& incomplete() const { return incomplete_; }

 private:
  OutputPaths paths_;
  std::vector<std::filesystem::path> incomplete_;
  std::optional<CsvWriter> csv_;
  std::optional<TumWriter> tum_;
  std::optional<JsonWriter> json_;
  std::optional<Overlay> overlay_;  // draws for the two below
  std::optional<OverlayVideo> video_;
  std::optional<ContactSheet> sheet_;
};

}  // namespace holdfast::app
