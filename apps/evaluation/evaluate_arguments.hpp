#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common_options.hpp"
#include "evaluation/protocol.hpp"

namespace holdfast::app {

/// The options of `holdfast evaluate`, and what follows from them alone.
struct EvaluateArguments {
  std::vector<std::string> folders;
  std::vector<std::string> models;
  std::optional<double> model_scale;
  std::optional<int> bop_object;

  std::string protocol = "never-reset";
  std::vector<int> steps = {1};
  double minimum_visible = 0;
  bool show_start_frame = true;
  evaluation::StartOptions starts;
  std::vector<double> start_error = {10, 5};  // mm, degrees

  std::filesystem::path poses;
  std::filesystem::path truth;
  bool partial = false;
  std::filesystem::path marks;
  std::vector<double> within;
  std::filesystem::path camera;

  std::filesystem::path csv;
  std::filesystem::path json;
  std::filesystem::path plots;
  std::filesystem::path pictures;
  std::vector<int> picture_frames;
  bool details = false;
  bool quiet = false;
  std::filesystem::path config;

  TrackerArguments tracker;
  DeviceArguments device;

  void add_to(CLI::App& app);
  /// Throws Error(invalid_argument) for options that would change nothing.
  void refuse_idle_options(const CLI::App& app) const;
  bool rbot() const;
  bool wrong_starts() const;
  bool needs_model_distances() const { return details || !json.empty() || !plots.empty(); }
};

}  // namespace holdfast::app
