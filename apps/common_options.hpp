#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/device.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/options.hpp"
#include "holdfast/pose.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

/// Options that several subcommands share. Each is a struct whose add_to() binds it to a subcommand; it must live until
/// the command line is parsed (keep it in a shared_ptr that the subcommand's callback holds).
namespace holdfast::app {

/// A message of the library where it speaks of an argument, in the words of whoever passes it: `words` with all of
/// `from` replaced by `to`.
struct Rewording {
  std::string_view from, to;
};
std::string reworded(std::string message, const std::vector<Rewording>& words);

/// io::camera_for_frames(), whose errors name the option --rescale-camera.
Camera camera_for_frames(const Camera& camera, int width, int height, bool rescale);

/// --model, --model-scale
struct ModelArguments {
  std::filesystem::path path;
  double scale = 1;

  void add_to(CLI::App& app, bool required = true);
  /// Prints a warning for what is missing in the file or not supported. Throws Error(file, model), and where
  /// `with_look` as require_named_materials().
  Mesh load(bool with_look = false) const;
};

/// --camera, --rescale-camera, --pixel-centres
struct CameraArguments {
  std::filesystem::path path;
  bool rescale = false;
  double pixel_centres = 0;  ///< coordinate of the first pixel's centre in the calibration

  /// `without`: what happens when it is not given.
  void add_to(CLI::App& app, bool required = true, const char* without = "");
  /// The camera for frames of this size; throws Error(file, camera).
  Camera load(int frame_width, int frame_height) const;
  /// The camera as the file has it, its pixel centres at whole numbers.
  Camera load() const;
};

/// As it stands in reports: "polynomial" or "fisheye".
const char* lens_name(LensModel lens);

/// --init
struct InitPoseArguments {
  std::filesystem::path path;

  /// `without`: what happens when it is not given.
  void add_to(CLI::App& app, bool required = true, const char* without = "");
  /// Warns where the file holds more. Throws Error(file, pose).
  Pose load() const;
};

/// A warning where a pose file holds more than the one that is taken.
std::optional<std::string> surplus_poses(const std::filesystem::path& path);

/// --renderer, else HOLDFAST_RENDERER.
CLI::Option* add_renderer_option(CLI::App& app, RendererChoice& choice);

/// --device, --partition, --cache-folder, --renderer
struct DeviceArguments {
  DeviceOptions options;

  void add_to(CLI::App& app);
  /// Throws Error(device).
  Device open() const { return Device(options); }
};

/// Value of --mode: TrackerOptions(), fast() or paper().
enum class Preset { standard, fast, paper };

/// --mode and an option for each field of TrackerOptions. What is not given keeps the mode's value.
class TrackerArguments {
 public:
  TrackerArguments() = default;
  TrackerArguments(const TrackerArguments&) = delete;
  TrackerArguments& operator=(const TrackerArguments&) = delete;

  void add_to(CLI::App& app);
  /// Throws Error(invalid_argument) naming what is out of range, or has no effect in paper mode or beside another
  /// option.
  TrackerOptions options() const;
  /// Throws Error(invalid_argument) for an option that does nothing for a model without texture and colours.
  void refuse_for_plain() const;
  /// As it is given to --mode.
  const char* mode_name() const;

 private:
  template <class Field>
  void add(CLI::App& app, const char* names, Field field, const char* description);

  /// Options of a part that is switched off.
  void require_parts(const TrackerOptions& options) const;

  const CLI::App* app_ = nullptr;
  Preset preset_ = Preset::standard;
  TrackerOptions given_;
  std::vector<std::function<void(TrackerOptions&)>> overrides_;  // each copies one field if its option was given
};

/// Throws Error(invalid_argument) for the name of a model to write that does not end in .obj.
void require_model_name(const std::filesystem::path& path);

/// Throws Error(model) for a mesh without texture and vertex colours whose OBJ names a material file that is not there.
void require_named_materials(const Mesh& mesh, const std::filesystem::path& model);

/// Prints a warning when the object's size is implausible, alone or at this pose, and returns true.
bool warn_about_units(const Mesh& mesh, const std::optional<Pose>& T_camera_object = std::nullopt,
                      const std::optional<Camera>& camera = std::nullopt);

}  // namespace holdfast::app
