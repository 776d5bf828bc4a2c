#include "common_options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>

#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "idle_options.hpp"
#include "messages.hpp"

namespace holdfast::app {
namespace {

constexpr const char* kInputGroup = "Object and camera";
constexpr const char* kDeviceGroup = "Device";
constexpr const char* kTrackerGroup = "Tracker";

/// An option that takes one of a few words.
template <class Value>
CLI::Option* add_choice(CLI::App& app, const char* name, Value& value, const std::map<std::string, Value>& words,
                        const std::string& description, const std::string& variable = "") {
  std::string list;
  for (const auto& [word, meaning] : words) {
    list += (list.empty() ? "" : "|") + word;
  }
  // No check(): newer versions of CLI11 pass over what a variable has where that fails.
  const auto choose = [&value, words, list, variable, option = std::string(name)](const std::string& word) {
    if (!words.contains(word)) {
      const std::string source = variable.empty() ? "" : " (from the option or " + variable + ")";
      throw CLI::ValidationError(option, "'" + word + "'" + source + " is none of " + list);
    }
    value = words.at(word);
  };
  return app.add_option_function<std::string>(name, choose, description)->envname(variable)->type_name(list);
}

/// The library names an option's field, "option vote_share ..."; here it is the flag that was typed.
std::string with_flag(const std::string& message) {
  constexpr std::string_view mark = "option ";
  if (!message.starts_with(mark)) {
    return message;
  }
  std::string flag = message.substr(mark.size(), message.find(' ', mark.size()) - mark.size());
  const std::string rest = message.substr(mark.size() + flag.size());
  constexpr std::string_view unit = "_ms";
  if (flag.ends_with(unit)) flag.resize(flag.size() - unit.size());
  std::replace(flag.begin(), flag.end(), '_', '-');
  return "--" + flag + rest;
}

const std::map<std::string, Preset> kPresets = {
    {"default", Preset::standard}, {"fast", Preset::fast}, {"paper", Preset::paper}};

TrackerOptions options_of(Preset preset) {
  switch (preset) {
    case Preset::fast:
      return TrackerOptions::fast();
    case Preset::paper:
      return TrackerOptions::paper();
    case Preset::standard:
      break;
  }
  return {};
}

/// One view and one solution a frame, as in `paper`, have no use for these.
void require_effect_in_paper_mode(const TrackerOptions& options, const TrackerOptions& paper, const std::string& mode) {
  const auto require_same = [&](auto given, auto own, const char* flag) {
    if (given != own) {
      throw Error(ErrorCode::invalid_argument, std::string(flag) + " has no effect beside --mode " + mode +
                                                   ", which draws one view and solves once a frame: leave one of "
                                                   "them out");
    }
  };
  require_same(options.levels, paper.levels, "--levels");
  require_same(options.search_radius, paper.search_radius, "--search-radius");
  require_same(options.motion_blur, paper.motion_blur, "--motion-blur");
  require_same(options.contour, paper.contour, "--contour");
  require_same(options.recovery, paper.recovery, "--recovery");
}

}  // namespace

void ModelArguments::add_to(CLI::App& app, bool required) {
  app.add_option("--model", path, "Model: OBJ, PLY, OFF, glTF or anything else that assimp reads")
      ->required(required)
      ->type_name("FILE")
      ->group(kInputGroup);
  app.add_option("--model-scale", scale, "The model's unit in metres: 0.001 for millimetres")
      ->capture_default_str()
      ->type_name("FACTOR")
      ->group(kInputGroup);
}

Mesh ModelArguments::load(bool with_look) const {
  std::vector<std::string> remarks;
  Mesh mesh = io::load_model(path, scale, &remarks);
  if (with_look) require_named_materials(mesh, path);
  for (const std::string& remark : remarks) print_warning(remark);
  return mesh;
}

void CameraArguments::add_to(CLI::App& app, bool required, const char* without) {
  app.add_option(
         "--camera", path,
         std::string("Camera: OpenCV calibration (YAML, JSON, XML), ROS camera_info, Kalibr, or 'fx fy cx cy'") +
             without)
      ->required(required)
      ->type_name("FILE")
      ->group(kInputGroup);
  add_choice<double>(app, "--pixel-centres", pixel_centres, {{"0", 0.0}, {"0.5", 0.5}},
                     "Where the calibration has the first pixel's centre: OpenCV and ROS at 0, COLMAP at 0.5 [0]")
      ->group(kInputGroup);
  app.add_flag("--rescale-camera", rescale, "Frames are the calibration's view scaled to another size")
      ->group(kInputGroup);
}

std::string reworded(std::string message, const std::vector<Rewording>& words) {
  for (const auto& [from, to] : words) {
    if (const std::size_t at = message.find(from); at != message.npos) message.replace(at, from.size(), to);
  }
  return message;
}

Camera camera_for_frames(const Camera& camera, int width, int height, bool rescale) {
  try {
    return io::camera_for_frames(camera, width, height, rescale);
  } catch (const Error& error) {
    throw Error(error.code(), reworded(error.what(), {{"rescale it if", "pass --rescale-camera if"},
                                                      {"cannot be rescaled: give",
                                                       "cannot be rescaled: leave --rescale-camera out "
                                                       "and give"}}));
  }
}

Camera CameraArguments::load() const {
  Camera camera = io::load_camera(path);
  camera.cx -= pixel_centres;
  camera.cy -= pixel_centres;
  return camera;
}

Camera CameraArguments::load(int frame_width, int frame_height) const {
  return camera_for_frames(load(), frame_width, frame_height, rescale);
}

const char* lens_name(LensModel lens) { return lens == LensModel::fisheye ? "fisheye" : "polynomial"; }

void InitPoseArguments::add_to(CLI::App& app, bool required, const char* without) {
  app.add_option(
         "--init", path,
         std::string("First pose, object to camera, metres: 3x4 or 4x4 matrix, TUM, rvec and tvec ('holdfast init')") +
             without)
      ->required(required)
      ->type_name("FILE")
      ->group(kInputGroup);
}

Pose InitPoseArguments::load() const {
  const Pose first = io::load_pose(path);
  warn_if(surplus_poses(path));
  return first;
}

std::optional<std::string> surplus_poses(const std::filesystem::path& path) {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(path, unknown)) return {};  // a pipe is read once
  try {
    const std::size_t count = io::load_poses(path).size();
    if (count > 1) return "'" + path.string() + "' holds " + std::to_string(count) + " poses: the first one is taken";
  } catch (const Error&) {  // one pose over several lines
  }
  return {};
}

CLI::Option* add_renderer_option(CLI::App& app, RendererChoice& choice) {
  return add_choice<RendererChoice>(
      app, "--renderer", choice, {{"osmesa", RendererChoice::osmesa}, {"egl", RendererChoice::egl}},
      "Which OpenGL draws the model: OSMesa on the CPU, EGL on a GPU where there is one [osmesa, else egl]",
      "HOLDFAST_RENDERER");
}

void DeviceArguments::add_to(CLI::App& app) {
  app.add_option("--device", options.device,
                 "OpenCL device: cpu, gpu, P:D or part of a name [HOLDFAST_DEVICE, else a CPU] ('holdfast devices')")
      ->type_name("NAME")
      ->group(kDeviceGroup);
  add_choice<Partition>(app, "--partition", options.partition,
                        {{"auto", Partition::automatic}, {"strips", Partition::strips}, {"groups", Partition::groups}},
                        "How kernels divide their work [auto]")
      ->group(kDeviceGroup);
  app.add_option("--cache-folder", options.cache_folder,
                 "Folder of compiled kernels [HOLDFAST_CACHE_DIR, else ~/.cache/holdfast]")
      ->type_name("FOLDER")
      ->group(kDeviceGroup);
  add_renderer_option(app, options.renderer)->group(kDeviceGroup);
}

template <class Field>
void TrackerArguments::add(CLI::App& app, const char* names, Field field, const char* description) {
  auto& value = field(given_);
  using Value = std::remove_reference_t<decltype(value)>;
  CLI::Option* option = nullptr;
  if constexpr (std::is_same_v<Value, bool>) {
    option = app.add_flag(names, value, std::string(description) + (value ? " [yes]" : " [no]"));
  } else {
    option = app.add_option(names, value, description)->capture_default_str();
    if constexpr (std::is_same_v<Value, std::vector<std::string>>) {
      option->delimiter(',')->allow_extra_args(false)->type_name("NAME,...");
    }
  }
  option->group(kTrackerGroup);
  overrides_.push_back([option, field, this](TrackerOptions& options) {
    if (option->count() > 0) {
      TrackerOptions given = given_;
      field(options) = field(given);
    }
  });
}

void TrackerArguments::add_to(CLI::App& app) {
  using O = TrackerOptions;
  app_ = &app;
  add_choice<Preset>(
      app, "--mode", preset_, kPresets,
      "Everything; the same of fewer pixels, in less time; or one view and one solution a frame from texture alone, "
      "as the paper's tracker [default, whose values are listed here]")
      ->group(kTrackerGroup);
  add(
      app, "--levels", [](O& o) -> int& { return o.levels; }, "Most pyramid levels");
  add(
      app, "--search-radius", [](O& o) -> int& { return o.search_radius; },
      "Of the search for the shift since the last frame, pixels of the frame");
  add(
      app, "--contour,!--no-contour", [](O& o) -> bool& { return o.contour; },
      "Follow the contour too; otherwise a model without texture is an error");
  add(
      app, "--light-compensation,!--no-light-compensation", [](O& o) -> bool& { return o.light_compensation; },
      "Gain and bias of the camera, light from one side");
  add(
      app, "--motion-blur,!--no-motion-blur", [](O& o) -> bool& { return o.motion_blur; },
      "Draw the view as blurred as the shutter makes it");
  add(
      app, "--recovery,!--no-recovery", [](O& o) -> bool& { return o.recovery; },
      "Search a lost object over the whole picture");
  add(
      app, "--recovery-budget", [](O& o) -> double& { return o.recovery_budget_ms; },
      "Nominal milliseconds of that search in one frame; it goes on in the next");
  add(
      app, "--gradient-test,!--no-gradient-test", [](O& o) -> bool& { return o.occlusion.gradient_test; },
      "Occlusion test (5): a gradient in both images");
  add(
      app, "--angle-test,!--no-angle-test", [](O& o) -> bool& { return o.occlusion.angle_test; },
      "Occlusion test (6): gradients point the same way");
  add(
      app, "--magnitude-test,!--no-magnitude-test", [](O& o) -> bool& { return o.occlusion.magnitude_test; },
      "Occlusion test (7): gradients differ little");
  add(
      app, "--block-vote,!--no-block-vote", [](O& o) -> bool& { return o.occlusion.block_vote; },
      "A pixel counts only where most of its neighbourhood passed");
  add(
      app, "--angle-together,!--angle-each", [](O& o) -> bool& { return o.occlusion.angle_together; },
      "Test (6) compares all channels' gradients at once, not each");
  add(
      app, "--gradient-minimum", [](O& o) -> double& { return o.occlusion.gradient_minimum; },
      "t_gm of test (5), intensity in [0, 1] a pixel");
  add(
      app, "--angle-maximum", [](O& o) -> double& { return o.occlusion.angle_maximum; },
      "t_theta of test (6), radians");
  add(
      app, "--difference-maximum", [](O& o) -> double& { return o.occlusion.difference_maximum; },
      "t_md of test (7), intensity a pixel");
  add(
      app, "--difference-relative", [](O& o) -> double& { return o.occlusion.difference_relative; },
      "Test (7) also lets pass this share of the larger gradient");
  add(
      app, "--vote-share", [](O& o) -> double& { return o.occlusion.vote_share; },
      "Share of the neighbourhood's gradient pixels that must pass");
  add(
      app, "--redundancy,!--no-redundancy", [](O& o) -> bool& { return o.occlusion.redundancy; },
      "Add up channels whose gradient repeats the strongest one's direction");
  add(
      app, "--redundancy-cosine", [](O& o) -> double& { return o.occlusion.redundancy_cosine; },
      "|cos| above which a channel repeats another");
  add(
      app, "--ablate", [](O& o) -> std::vector<std::string>& { return o.ablate; },
      "Mechanisms to leave out, for experiments");
}

void TrackerArguments::require_parts(const TrackerOptions& options) const {
  const auto require = [this](bool on, const char* part, std::initializer_list<const char*> of_it) {
    refuse_without(*app_, of_it, on, part);
  };
  const OcclusionOptions& tests = options.occlusion;
  require(tests.gradient_test, "--gradient-test", {"--gradient-minimum"});
  require(tests.angle_test, "--angle-test", {"--angle-maximum", "--angle-together"});
  require(tests.magnitude_test, "--magnitude-test", {"--difference-maximum", "--difference-relative"});
  require(tests.block_vote, "--block-vote", {"--vote-share"});
  require(tests.redundancy, "--redundancy", {"--redundancy-cosine"});
  require(options.recovery, "--recovery", {"--recovery-budget"});
  for (const std::string& mechanism : options.ablate) {
    const bool idle = mechanism == "shift_search";
    refuse_beside(*app_, {"--search-radius"}, idle, "--ablate " + mechanism);
  }
}

void TrackerArguments::refuse_for_plain() const {
  refuse_without(*app_,
                 {"--search-radius", "--gradient-test", "--angle-test", "--magnitude-test", "--block-vote",
                  "--angle-together", "--gradient-minimum", "--angle-maximum", "--difference-maximum",
                  "--difference-relative", "--vote-share", "--redundancy", "--redundancy-cosine", "--views"},
                 false, "a texture or colours in the model");
}

const char* TrackerArguments::mode_name() const {
  const auto named =
      std::find_if(kPresets.begin(), kPresets.end(), [this](const auto& preset) { return preset.second == preset_; });
  return named->first.c_str();
}

TrackerOptions TrackerArguments::options() const {
  TrackerOptions options = options_of(preset_);
  for (const auto& override_field : overrides_) {
    override_field(options);
  }
  if (options.quality == Quality::paper) {
    require_effect_in_paper_mode(options, options_of(preset_), mode_name());
  }
  try {
    options.validate();
  } catch (const Error& error) {
    throw Error(error.code(), with_flag(error.what()));
  }
  require_parts(options);
  return options;
}

void require_model_name(const std::filesystem::path& path) {
  if (path.extension() != ".obj") {
    throw Error(ErrorCode::invalid_argument,
                "'" + path.string() + "' cannot be written: models are written as OBJ, give a name ending in .obj");
  }
}

void require_named_materials(const Mesh& mesh, const std::filesystem::path& model) {
  if (mesh.has_appearance() || model.extension() != ".obj" || io::model_files(model).size() > 1) {
    return;  // not plain, or its material file was found
  }
  constexpr std::string_view keyword = "mtllib ";
  std::ifstream file(model);
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(keyword)) {
      continue;
    }
    line.erase(0, keyword.size());
    line.erase(line.find_last_not_of(" \t\r") + 1);
    throw Error(ErrorCode::model,
                "model '" + model.string() + "' has no texture, because the material file that it names, '" + line +
                    "', is not beside it: copy it there, with its pictures, or make a texture with 'holdfast bake'");
  }
}

bool warn_about_units(const Mesh& mesh, const std::optional<Pose>& T_camera_object,
                      const std::optional<Camera>& camera) {
  const std::optional<std::string> doubt = io::unit_warning(mesh, T_camera_object, camera);
  if (!doubt) return false;
  warn_if(reworded(*doubt, {{"scale it by", "pass --model-scale"}, {"multiply the scale", "multiply --model-scale"}}));
  return true;
}

}  // namespace holdfast::app
