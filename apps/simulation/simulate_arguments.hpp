#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "simulation/sequence.hpp"
#include "simulation/sequence_files.hpp"
#include "simulation/textured_box.hpp"

namespace holdfast::simulation {

/// The options of `holdfast simulate`.
struct SimulateArguments {
  std::filesystem::path folder;
  SequenceOptions sequence;
  SequenceFileOptions files;
  BoxOptions box;
  bool quiet = false;
  bool report = false;
  bool frames_given = false;

  std::string model = "box";
  double model_scale = 1;
  std::filesystem::path camera;
  std::string size = "640x480";
  bool size_given = false;
  double view_angle = 0;
  bool rescale_camera = false;

  std::string motion = "smooth";
  std::vector<double> distance;  // nearest, farthest
  double rotation_degrees = 35;
  std::vector<double> orientation;  // yaw, pitch, roll, degrees
  std::filesystem::path trajectory;

  std::vector<std::string> occluders;
  OccluderOptions occluder;  // what all bars and cubes share
  std::vector<std::string> occluder_models;
  std::vector<std::string> occluder_trajectories;
  double occluder_scale = 1;

  std::vector<std::string> lights;
  std::vector<double> light_orbit;  // radius, frames a turn

  void add_to(CLI::App& command);
  /// After parsing: what was given, and a refusal of options that would change nothing in the frames asked for. Throws
  /// Error(invalid_argument).
  void check(const CLI::App& command);
};

}  // namespace holdfast::simulation
