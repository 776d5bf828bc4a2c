#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "common_options.hpp"
#include "holdfast/tracker.hpp"
#include "track/object_search.hpp"
#include "track/run_files.hpp"
#include "video/frame_source.hpp"

namespace holdfast::app {

/// The options of `holdfast track`, and what follows from them alone.
struct TrackCommand {
  std::string input;
  ModelArguments model;
  CameraArguments camera;
  InitPoseArguments init;
  std::filesystem::path guide;
  std::filesystem::path views;
  std::filesystem::path remembered;
  std::filesystem::path camera_out;
  DeviceArguments device;
  TrackerArguments tracker;
  std::int64_t start = 0;
  std::optional<std::int64_t> stop;
  std::int64_t stride = 1;
  double frame_rate = 0;
  OutputPaths outputs;
  std::filesystem::path completed_model;
  bool require_held = false;
  bool show = false;
  bool quiet = false;
  std::filesystem::path config;
  std::string given;  ///< options, as a configuration file has them

  void add_to(CLI::App& command);
  /// Refuses what would do nothing, and what cannot go together. Throws Error(invalid_argument).
  void check(const CLI::App& command) const;
  FrameSourceOptions source_options() const;
  Recognition recognition() const { return {views, remembered, device.options, quiet}; }
  /// Throws Error(model) for a model that nothing tells the first pose of.
  void require_start(const Mesh& mesh) const;
  /// The camera that the file tells, or one whose focal length is estimated from the frames.
  Camera camera_of(FrameSource& source, const Mesh& mesh) const;
  /// The run's description, a JSON object's text.
  std::string run_json(const Tracker& used) const;
  /// The exit code.
  int run() const;
};

}  // namespace holdfast::app
