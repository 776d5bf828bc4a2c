#include "common_options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <initializer_list>
#include <map>
#include <numbers>
#include <string>
#include <string_view>
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
                        const std::string& description) {
  std::string list;
  for (const auto& [word, meaning] : words) {
    list += (list.empty() ? "" : "|") + word;
  }
  const auto choose = [&value, words](const std::string& word) { value = words.at(word); };
  return app.add_option_function<std::string>(name, choose, description)
      ->check([words, list](const std::string& word) {
        return words.contains(word) ? std::string() : "'" + word + "' is none of " + list;
      })
      ->type_name(list);
}

/// The library names an option's field, "option vote_share ..."; here it is the flag that was typed.
std::string with_flag(const std::string& message) {
  constexpr std::string_view mark = "option ";
  if (!message.starts_with(mark)) {
    return message;
  }
  std::string flag = message.substr(mark.size(), message.find(' ', mark.size()) - mark.size());
  const std::string rest = message.substr(mark.size() + flag.size());
  std::replace(flag.begin(), flag.end(), '_', '-');
  return "--" + flag + rest;
}

const std::map<std::string, Preset> kPresets = {
    {"default", Preset::standard}, {"fast", Preset::fast}, {"paper", Preset::paper}, {"published", Preset::published}};

TrackerOptions options_of(Preset preset) {
  switch (preset) {
    case Preset::fast:
      return TrackerOptions::fast();
    case Preset::paper:
      return TrackerOptions::paper();
    case Preset::published:
      return TrackerOptions::published();
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
  require_same(options.finest_level, paper.finest_level, "--finest-level");
  require_same(options.most_pixels, paper.most_pixels, "--most-pixels");
  require_same(options.enough_pixels, paper.enough_pixels, "--enough-pixels");
  require_same(options.iterations, paper.iterations, "--iterations");
  require_same(options.correlation_search, paper.correlation_search, "--correlation-search");
  require_same(options.search_radius, paper.search_radius, "--search-radius");
  require_same(options.motion_blur, paper.motion_blur, "--motion-blur");
  require_same(options.outline, paper.outline, "--outline");
  require_same(options.faint_deviation, paper.faint_deviation, "--faint-deviation");
  require_same(options.coarse_color, paper.coarse_color, "--coarse-color");
  require_same(options.fine_blur_sigma, paper.fine_blur_sigma, "--fine-blur-sigma");
  require_same(options.tone_curve, paper.tone_curve, "--tone-curve");
  require_same(options.lens_blur, paper.lens_blur, "--lens-blur");
  require_same(options.challenge, paper.challenge, "--challenge");
  require_same(options.recovery, paper.recovery, "--recovery");
}

}  // namespace

void ModelArguments::add_to(CLI::App& app, bool required) {
  app.add_option("--model", path, "Model: OBJ, PLY, glTF or anything else that assimp reads")
      ->required(required)
      ->type_name("FILE")
      ->group(kInputGroup);
  app.add_option("--model-scale", scale, "The model's unit in metres: 0.001 for millimetres")
      ->capture_default_str()
      ->type_name("FACTOR")
      ->group(kInputGroup);
}

Mesh ModelArguments::load() const { return io::load_model(path, scale); }

void CameraArguments::add_to(CLI::App& app, bool required) {
  app.add_option("--camera", path, "Camera: OpenCV calibration (YAML, JSON, XML), ROS camera_info, or 'fx fy cx cy'")
      ->required(required)
      ->type_name("FILE")
      ->group(kInputGroup);
  app.add_flag("--rescale-camera", rescale, "Frames are the calibration's view scaled to another size")
      ->group(kInputGroup);
}

Camera CameraArguments::load(int frame_width, int frame_height) const {
  return io::camera_for_frames(io::load_camera(path), frame_width, frame_height, rescale);
}

void InitPoseArguments::add_to(CLI::App& app, bool required) {
  app.add_option("--init", path, "First pose, object to camera, metres: 3x4 or 4x4 matrix or TUM ('holdfast init')")
      ->required(required)
      ->type_name("FILE")
      ->group(kInputGroup);
}

Pose InitPoseArguments::load() const { return io::load_pose(path); }

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
      "Everything; that for a tenth to half of the time; one view and one solution a frame, as the paper's "
      "tracker but steadied; or that as published [default, whose values are listed here]")
      ->group(kTrackerGroup);

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
      app, "--all-channels,!--any-channel", [](O& o) -> bool& { return o.occlusion.all_channels; },
      "Test (5) asks all channels for a gradient, not any");
  add(
      app, "--angle-together,!--angle-each", [](O& o) -> bool& { return o.occlusion.angle_together; },
      "Test (6) compares all channels' gradients at once, not each");
  add(
      app, "--compare-magnitudes,!--compare-vectors", [](O& o) -> bool& { return o.occlusion.compare_magnitudes; },
      "Test (7) compares lengths of gradients, not vectors");
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
      app, "--vote-relative,!--no-vote-relative", [](O& o) -> bool& { return o.occlusion.vote_relative; },
      "The vote asks for a share of what passes where nothing is in front");

  add(
      app, "--redundancy,!--no-redundancy", [](O& o) -> bool& { return o.redundancy; },
      "Add up channels whose gradient repeats the strongest one's direction");
  add(
      app, "--redundancy-cosine", [](O& o) -> double& { return o.redundancy_cosine; },
      "|cos| above which a channel repeats another");
  add(
      app, "--blur-sigma", [](O& o) -> double& { return o.blur_sigma; },
      "Gaussian of both images, pixels of the level");
  add(
      app, "--fine-blur-sigma", [](O& o) -> double& { return o.fine_blur_sigma; },
      "The same on the finest level, where frames show that the pose is surer with it");
  add(
      app, "--silhouette-margin", [](O& o) -> int& { return o.silhouette_margin; },
      "Most pixels dropped at silhouette and depth jumps");
  add(
      app, "--depth-jump", [](O& o) -> double& { return o.depth_jump; }, "Relative depth step that counts as a jump");
  add(
      app, "--levels", [](O& o) -> int& { return o.levels; }, "Most pyramid levels");
  add(
      app, "--finest-level", [](O& o) -> int& { return o.finest_level; }, "0: full resolution, 1: half");
  add(
      app, "--texture-samples", [](O& o) -> int& { return o.texture_samples; },
      "Of the rendered view, a pixel: 1, or 4 averaged as light");
  add(
      app, "--mesh-deviation", [](O& o) -> double& { return o.mesh_deviation; },
      "Pixels that a mesh drawn with fewer triangles may be off, its texture twice; 0: all are drawn");
  add(
      app, "--most-pixels", [](O& o) -> int& { return o.most_pixels; },
      "An object of more is tracked at half the resolution");
  add(
      app, "--enough-pixels", [](O& o) -> int& { return o.enough_pixels; },
      "With a gradient; of more, only every second to fourth row is looked at");
  add(
      app, "--iterations", [](O& o) -> int& { return o.iterations; }, "Most solved systems a level");
  add(
      app, "--robust-weights,!--no-robust-weights", [](O& o) -> bool& { return o.robust_weights; },
      "Student-t weights on what passes the tests");
  add(
      app, "--photometric,!--no-photometric", [](O& o) -> bool& { return o.photometric; },
      "Compensate gain and bias of each channel");
  add(
      app, "--shading,!--no-shading", [](O& o) -> bool& { return o.shading; },
      "Draw the view as the light falls on it, learnt from the frames");
  add(
      app, "--tone-curve,!--no-tone-curve", [](O& o) -> bool& { return o.tone_curve; },
      "Draw the view as the camera encodes brightness, learnt with the light");
  add(
      app, "--light-texels,!--no-light-texels", [](O& o) -> bool& { return o.light_texels; },
      "Average texels as light where the frames show that a camera did; otherwise as encoded values");
  add(
      app, "--coarse-color,!--no-coarse-color", [](O& o) -> bool& { return o.coarse_color; },
      "Draw colour as coarse as codecs keep it, where the frames show that");
  add(
      app, "--lens-blur,!--no-lens-blur", [](O& o) -> bool& { return o.lens_blur; },
      "Draw the texture as blurred as the lens makes it, measured in the frames");
  add(
      app, "--mean-gradient,!--no-mean-gradient", [](O& o) -> bool& { return o.mean_gradient; },
      "Rows from the mean of rendered and frame gradients");
  add(
      app, "--predict-velocity,!--no-predict-velocity", [](O& o) -> bool& { return o.predict_velocity; },
      "Try going on as it moved beside no motion");
  add(
      app, "--expected-motion,!--no-expected-motion", [](O& o) -> bool& { return o.expected_motion; },
      "Where its motion leads counts beside the rows, as surely as poses are known");
  add(
      app, "--correlation-search,!--no-correlation-search", [](O& o) -> bool& { return o.correlation_search; },
      "Shift search on the coarsest level");
  add(
      app, "--motion-blur,!--no-motion-blur", [](O& o) -> bool& { return o.motion_blur; },
      "Draw the view as blurred as the shutter makes it");
  add(
      app, "--challenge,!--no-challenge", [](O& o) -> bool& { return o.challenge; },
      "Challenge results worse than usual with other starts");
  add(
      app, "--recovery,!--no-recovery", [](O& o) -> bool& { return o.recovery; },
      "Search a lost object over the whole picture");
  add(
      app, "--outline,!--no-outline", [](O& o) -> bool& { return o.outline; },
      "Follow the outline too where texture says little, and alone where there is none; otherwise a model without any "
      "is "
      "an error");
  add(
      app, "--faint-deviation", [](O& o) -> double& { return o.faint_deviation; },
      "Standard deviation of the pose by texture, object radii and radians, above which the outline is followed too");
  add(
      app, "--search-radius", [](O& o) -> int& { return o.search_radius; },
      "Of the shift search, pixels of the full frame");
  add(
      app, "--lost-correlation", [](O& o) -> double& { return o.lost_correlation; },
      "Correlation below which the object is lost");
  add(
      app, "--lost-visible-share", [](O& o) -> double& { return o.lost_visible_share; },
      "Share of gradient pixels used below which the object is lost");
}

void TrackerArguments::require_parts(const TrackerOptions& options) const {
  const auto require = [this](bool on, const char* part, std::initializer_list<const char*> of_it) {
    refuse_without(*app_, of_it, on, part);
  };
  const OcclusionOptions& tests = options.occlusion;
  require(tests.gradient_test, "--gradient-test", {"--all-channels"});
  require(tests.angle_test, "--angle-test", {"--angle-maximum", "--angle-together"});
  require(tests.magnitude_test, "--magnitude-test",
          {"--difference-maximum", "--difference-relative", "--compare-magnitudes"});
  require(tests.block_vote, "--block-vote", {"--vote-share", "--vote-relative"});
  require(options.redundancy, "--redundancy", {"--redundancy-cosine"});
  require(options.correlation_search, "--correlation-search", {"--search-radius"});
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
  if (options.mode == Mode::paper) {
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
  if (mesh.has_appearance() || model.extension() != ".obj") {
    return;
  }
  constexpr std::string_view keyword = "mtllib ";
  std::ifstream file(model);
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(keyword)) {
      continue;
    }
    line.erase(0, keyword.size());
    line.erase(line.find_last_not_of(" \t\r") + 1);
    if (!std::filesystem::exists(model.parent_path() / line)) {
      throw Error(ErrorCode::model,
                  "model '" + model.string() + "' has no texture, because the material file that it names, '" + line +
                      "', is not beside it: copy it there, with its pictures, or make a texture with 'holdfast bake'");
    }
  }
}

void warn_about_units(const Mesh& mesh, const std::optional<Pose>& T_camera_object,
                      const std::optional<Camera>& camera) {
  warn_if(io::unit_warning(mesh, T_camera_object, camera));
}

}  // namespace holdfast::app
