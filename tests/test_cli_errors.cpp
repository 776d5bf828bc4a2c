#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <filesystem>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "exit_codes.hpp"
#include "holdfast/io.hpp"
#include "support/files.hpp"
#include "support/run_program.hpp"
#include "support/small_sequence.hpp"

namespace fs = std::filesystem;
using namespace holdfast;
using namespace holdfast::app;
using namespace holdfast::test;

namespace {

Pose at(double x, double y, double z) { return Pose(Eigen::Translation3d(x, y, z)); }

/// What `holdfast track` and `init` need, made once; names are relative to the folder that the program runs in.
class Inputs {
 public:
  Inputs() {
    const Pose first = write_small_sequence(folder_, 3).front();
    std::string pairs;
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector3d corner(i & 1 ? 0.1 : -0.1, i & 2 ? 0.075 : -0.075, i & 4 ? 0.04 : -0.04);
      const Eigen::Vector2d pixel = kSmallCamera.project(first * corner);
      for (const double value : {corner.x(), corner.y(), corner.z(), pixel.x()}) {
        pairs += std::to_string(value) + ",";
      }
      pairs += std::to_string(pixel.y()) + "\n";
    }
    folder_.write("pairs.csv", pairs);
  }

  const TemporaryFolder& folder() const { return folder_; }

  ProgramRun run(const Arguments& arguments, const Environment& environment = {}) const {
    return run_holdfast(arguments, folder_, environment);
  }

 private:
  TemporaryFolder folder_;
};

const Inputs& inputs() {
  static const Inputs made;
  return made;
}

void write(const std::string& name, const std::string& text) { inputs().folder().write(name, text); }

/// `track` with everything in order but for what `changes` replaces or adds.
Arguments track(const Environment& changes, const std::string& input = "frames") {
  Environment options{{"--model", "box.obj"}, {"--camera", "camera.yml"}, {"--init", "first.txt"}};
  for (const auto& [name, value] : changes) {
    options[name] = value;
  }
  Arguments arguments{"track", input, "--quiet"};
  for (const auto& [name, value] : options) {
    arguments.push_back(name);
    if (!value.empty()) {
      arguments.push_back(value);
    }
  }
  return arguments;
}

Arguments init(const Environment& changes) {
  Environment options{{"--points", "pairs.csv"}, {"--camera", "camera.yml"}};
  for (const auto& [name, value] : changes) {
    options[name] = value;
  }
  Arguments arguments{"init"};
  for (const auto& [name, value] : options) {
    if (value != "(none)") {
      arguments.push_back(name);
      if (!value.empty()) {
        arguments.push_back(value);
      }
    }
  }
  return arguments;
}

/// The exit code, and one line on stderr that says all of `words`.
void check_fails(int exit_code, const Arguments& arguments, const std::vector<std::string>& words,
                 const Environment& environment = {}) {
  std::string command;
  for (const std::string& argument : arguments) {
    command += argument + " ";
  }
  CAPTURE(command);
  check_error(inputs().run(arguments, environment), exit_code, words);
}

}  // namespace

TEST_CASE("A run with everything in order says nothing on stderr") {
  const ProgramRun run = inputs().run(track({{"--poses", "fine.csv"}}));
  CAPTURE(run.err);
  CHECK(run.exit_code == kOk);
  CHECK(run.err.empty());
  const std::string poses = read_file(inputs().folder() / "fine.csv");
  CHECK(std::count(poses.begin(), poses.end(), '\n') == 4);  // heading and three frames

  const ProgramRun found = inputs().run(init({{"--pose", "found.txt"}}));
  CAPTURE(found.err);
  CHECK(found.exit_code == kOk);
  CHECK(found.err.empty());
  CHECK(found.out.find("rms") != std::string::npos);
  CHECK((io::load_pose(inputs().folder() / "found.txt").matrix() -
         io::load_pose(inputs().folder() / "first.txt").matrix())
            .norm() < 1e-4);
}

TEST_CASE("Help and version go to stdout") {
  for (const Arguments& arguments : {Arguments{"--help"}, Arguments{"--version"}, Arguments{"track", "--help"},
                                     Arguments{"init", "--help"}, Arguments{"devices", "--help"}}) {
    const ProgramRun run = inputs().run(arguments);
    CHECK(run.exit_code == kOk);
    CHECK(run.err.empty());
    CHECK(run.out.size() > 5);
  }
  CHECK(inputs().run({"--help"}).out.find("Exit codes") != std::string::npos);
}

TEST_CASE("Wrong options") {
  check_fails(kUsage, {}, {"a command is missing", "--help"});
  check_fails(kUsage, {"follow", "frames"}, {"no command 'follow' (see", "--help"});
  check_fails(kUsage, {"trakc", "frames"}, {"no command 'trakc'", "did you mean 'track'?"});
  check_fails(kUsage, track({{"frames2", ""}}), {"'frames2' is one argument too many", "quotes"});
  check_fails(kUsage, {"track", "frames"}, {"--model", "required", "track --help"});
  check_fails(kUsage, {"track", "frames", "--modle", "box.obj"}, {"no option '--modle'", "did you mean '--model'?"});
  check_fails(kUsage, track({{"--levels", "many"}}), {"--levels takes a number, not 'many'"});
  check_fails(kUsage, track({{"--stop", "2.5"}}), {"--stop takes a whole number, not '2.5'"});
  check_fails(kUsage, {"track", "frames", "--model"}, {"--model needs a value: FILE"});
  check_fails(kUsage, track({{"--mode", "quick"}}), {"--mode", "quick", "default|fast|paper"});
  check_fails(kUsage, track({{"--search-radius", "-1"}}), {"--search-radius", "[0, 512]"});
  check_fails(kUsage, track({{"--no-such-option", "1"}}), {"no option '--no-such-option' (see", "track --help"});
  check_fails(kUsage, track({{"--serach-radius=1", ""}}),
              {"no option '--serach-radius'", "did you mean '--search-radius'?"});
  check_fails(kUsage, track({{"--model-scale", "0"}}), {"scale"});
  check_fails(kUsage, track({{"--stride", "0"}}), {"stride"});
  check_fails(kUsage, track({{"--frame-rate", "0"}}), {"--frame-rate", "0 must be more than 0"});
  check_fails(kUsage, track({{"--frame-rate", "nan"}}), {"--frame-rate", "no number"});
  check_fails(kUsage, {"simulate", "not_made", "--ambient", "-1"}, {"--ambient", "-1 must be at least 0"});
  check_fails(kUsage, {"simulate", "not_made", "--speed", "fast"}, {"--speed", "'fast' is no number"});
  check_fails(kUsage, init({{"--click", ""}}), {"--points", "--click"});
  check_fails(kUsage, init({{"--estimate-focal", ""}}), {"--camera", "--estimate-focal"});
  check_fails(kUsage, init({{"--camera", "(none)"}, {"--estimate-focal", ""}}), {"--image"});
  check_fails(kUsage, init({{"--points", "(none)"}, {"--click", ""}}), {"--image", "--model"});
  check_fails(kUsage,
              init({{"--points", "(none)"}, {"--click", ""}, {"--image", "frames/0.png"}, {"--model", "box.obj"}}),
              {"display"}, {{"DISPLAY", ""}, {"WAYLAND_DISPLAY", ""}});
  check_fails(kUsage, init({{"--pose", "pairs.csv"}}), {"pairs.csv", "is an input"});
  check_fails(kUsage, init({{"--camera-out", "c.txt"}}), {"c.txt", ".yml"});
}

TEST_CASE("Options that would do nothing are refused") {
  const auto refused = [](Arguments arguments, const std::vector<std::string>& options, const std::string& what) {
    arguments.insert(arguments.end(), options.begin(), options.end());
    check_fails(kUsage, arguments, {options.front() + " has no effect " + what, "out"});
  };
  const auto simulate = [&](const std::vector<std::string>& options, const std::string& what) {
    refused({"simulate", "not_made"}, options, what);
  };
  for (const std::vector<std::string>& motion :
       {Arguments{"--speed", "5"}, Arguments{"--distance", "0.5,1"}, Arguments{"--rotation", "20"},
        Arguments{"--orientation", "0,0,0"}, Arguments{"--turns", "3"}, Arguments{"--ease", "3"}}) {
    simulate({motion[0], motion[1], "--trajectory", "first.txt"}, "beside --trajectory");
  }
  simulate({"--speed", "5", "--motion", "still"}, "beside --motion still");
  simulate({"--rotation", "5", "--motion", "still"}, "beside --motion still");
  simulate({"--turns", "3"}, "without --motion sharp");
  simulate({"--ease", "3", "--motion", "smooth"}, "without --motion sharp");
  simulate({"--model-scale", "0.001"}, "beside --model box");
  simulate({"--box-seed", "2", "--model", "box.obj"}, "without --model box");
  simulate({"--box-contrast", "0.5", "--model", "box.obj", "--occluder-model", "box"}, "without --model box");
  simulate({"--rescale-camera", "--camera", "camera.yml"}, "without --size");
  simulate({"--bar-width", "20"}, "without --occluder bar");
  simulate({"--bar-sweeps", "2", "--occluder", "cube"}, "without --occluder bar");
  simulate({"--cube-size", "0.5", "--occluder", "bar"}, "without --occluder cube");
  simulate({"--occluder-scale", "0.001", "--occluder-model", "box"}, "without --occluder-model FILE");
  simulate({"--shininess", "9"}, "without --specular");
  simulate({"--change-frames", "50"}, "without --exposure, --white-balance or --gamma");
  refused({"simulate", "--report"}, {"--masks"}, "without FOLDER");
  refused({"simulate", "--report"}, {"--overwrite"}, "without FOLDER");
  CHECK_FALSE(fs::exists(inputs().folder() / "not_made"));

  refused(track({}), {"--contact-frames", "5"}, "without --contact-sheet");
  refused(track({}), {"--recovery", "--mode", "paper"}, "beside --mode paper");
  refused(track({}), {"--gradient-minimum", "0.1", "--no-gradient-test"}, "without --gradient-test");
  refused(track({}), {"--angle-maximum", "0.3", "--no-angle-test"}, "without --angle-test");
  refused(track({}), {"--difference-maximum", "0.1"}, "without --magnitude-test");
  refused(track({}), {"--vote-share", "0.5", "--no-block-vote"}, "without --block-vote");
  refused(track({}), {"--redundancy-cosine", "0.8"}, "without --redundancy");
  refused(track({}), {"--recovery-budget", "9", "--no-recovery"}, "without --recovery");
  refused(track({}), {"--views", "not_made.views", "--no-recovery"}, "without --recovery");
  refused(track({}), {"--views", "not_made.views", "--mode", "paper"}, "beside --mode paper");
  refused(track({}), {"--views", "not_made.views", "--complete-model", "not_made.obj"}, "beside --complete-model");
  refused(track({}), {"--search-radius", "9", "--ablate", "shift_search"}, "beside --ablate shift_search");
  refused(init({}), {"--frame", "1"}, "without --image");
  refused(init({}), {"--rescale-camera"}, "without --image");
  refused({"init", "--points", "pairs.csv", "--image", "frames", "--estimate-focal"}, {"--rescale-camera"},
          "without --camera");

  const Arguments bake{"bake", "frames/0.png", "--model", "box.obj", "--camera", "camera.yml", "--out", "not_made.obj"};
  const auto baked = [&](const std::vector<std::string>& options, const std::string& what) {
    refused(bake, options, what);
  };
  baked({"--start", "1", "frames/1.png", "--poses", "first.txt"}, "beside several inputs");
  baked({"--stop", "1", "frames/1.png", "--poses", "first.txt"}, "beside several inputs");
  baked({"--levels", "2", "--poses", "first.txt"}, "beside --poses");
  baked({"--padding", "2", "--init", "first.txt"}, "on the texture coordinates");
  CHECK_FALSE(fs::exists(inputs().folder() / "not_made.obj"));

  const auto evaluate = [&](const std::vector<std::string>& options, const std::string& what) {
    refused({"evaluate"}, options, what);
  };
  evaluate({"--camera", "camera.yml"}, "without --marks");
  evaluate({"--within", "1,2", "--poses", "first.txt", "--truth", "first.txt"}, "without --marks");
  for (const std::string option : {"--model", "--truth", "--csv", "--json", "--plots"}) {
    evaluate({option, "x", "--marks", "m.csv", "--poses", "first.txt", "--camera", "camera.yml"}, "beside --marks");
  }
  evaluate({"--truth", "first.txt"}, "without --poses");
  evaluate({"--partial"}, "without --poses");
  for (const Arguments& tracking : {Arguments{"--protocol", "rbot"}, Arguments{"--step", "2"},
                                    Arguments{"--start-seed", "2"}, Arguments{"--search-radius", "2"}}) {
    evaluate({tracking[0], tracking[1], "--poses", "first.txt", "--truth", "first.txt"}, "beside --poses");
  }
  for (const std::string option : {"--model", "--model-scale"}) {
    evaluate({option, "1", "--poses", "first.txt", "--truth", "first.txt"}, "without --details");
  }
  evaluate({"--model-scale", "2", "--poses", "first.txt", "--truth", "first.txt", "--details"}, "without --model");
  evaluate({"--bop-object", "2", "--poses", "first.txt", "--truth", "first.txt"}, "beside --truth");
  evaluate({"--show-start-frame"}, "without --protocol rbot");
  for (const std::string option : {"--starts", "--start-frames", "--start-seed"}) {
    evaluate({option, "2"}, "without --protocol starts");
  }
  evaluate({"--start-error", "5,5", "--protocol", "rbot"}, "without --protocol starts");
  evaluate({"--step", "2", "--protocol", "starts"}, "beside --protocol starts");
  write("line.txt", "1 0 0 0 0 1 0 0 0 0 1 0.5\n");
  check_fails(kUsage, {"evaluate", "--poses", "line.txt", "--truth", "line.txt", "--min-visible", "0.5"},
              {"--min-visible", "visible.txt"});
}

TEST_CASE("Configuration files") {
  write("good.toml", "\xef\xbb\xbfstop = 2\nposes = \"config.csv\"\n[bake]\nnothing = 1\n[track]\nmode = \"paper\"\n");
  const ProgramRun run = inputs().run(track({{"--config", "good.toml"}}));
  CAPTURE(run.err);
  CHECK(run.exit_code == kOk);
  const std::string poses = read_file(inputs().folder() / "config.csv");
  CHECK(std::count(poses.begin(), poses.end(), '\n') == 3);
  check_fails(kUsage, track({{"--config", "none.toml"}}), {"--config", "none.toml"});
  check_fails(kUsage, track({{"--config", "frames"}}), {"--config", "frames", "directory"});
  write("bad.toml", "colour = \"green\"\n");
  check_fails(kUsage, track({{"--config", "bad.toml"}}), {"'bad.toml'", "'colour'", "'track'"});
  check_fails(kUsage, track({{"--config", "first.txt"}}), {"'first.txt'"});
  write("section.toml", "[trak]\nlevels = 2\n");
  check_fails(kUsage, track({{"--config", "section.toml"}}), {"'section.toml'", "[trak]", "[track]"});
  write("input.toml", "input = \"frames\"\nstop = 1\n");
  CHECK(inputs()
            .run({"track", "--config", "input.toml", "--model", "box.obj", "--camera", "camera.yml", "--init",
                  "first.txt", "--poses", "config.csv"})
            .exit_code == kOk);
  write("range.toml", "levels = 99\n");
  check_fails(kUsage, track({{"--config", "range.toml"}}), {"levels"});
}

TEST_CASE("Models") {
  check_fails(kInput, track({{"--model", "none.obj"}}), {"none.obj", "does not exist"});
  check_fails(kInput, track({{"--model", "frames"}}), {"frames", "folder"});
  check_fails(kInput, track({{"--model", "first.txt"}}), {"first.txt", "not supported"});
  write("broken.gltf", "{\"asset\":");
  check_fails(kInput, track({{"--model", "broken.gltf"}}), {"broken.gltf", "cannot be read"});
  write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
  check_fails(kInput, track({{"--model", "points.obj"}}), {"points.obj", "no triangles"});
  write("nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n");
  check_fails(kInput, track({{"--model", "nan.obj"}}), {"nan.obj", "NaN"});
  write("plain.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n");
  check_fails(kInput, track({{"--model", "plain.obj"}, {"--mode", "paper"}}),
              {"neither texture nor vertex colours", "holdfast bake"});
  write("lost.mtl", "newmtl m\nmap_Kd gone.png\n");
  write("lost.obj",
        "mtllib lost.mtl\nv 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3\n");
  check_fails(kInput, track({{"--model", "lost.obj"}}), {"lost.obj", "gone.png", "does not exist"});
}

TEST_CASE("Cameras") {
  check_fails(kInput, track({{"--camera", "none.yml"}}), {"none.yml", "does not exist"});
  write("bad.yml", "camera_matrix: [1, 2");
  check_fails(kInput, track({{"--camera", "bad.yml"}}), {"bad.yml", "YAML"});
  write("fov.yml",
        "image_width: 320\nimage_height: 240\ncamera_matrix: [325,0,160,0,325,120,0,0,1]\n"
        "distortion_model: fov\ndistortion_coefficients: [0,0,0,0]\n");
  check_fails(kInput, track({{"--camera", "fov.yml"}}), {"fov.yml", "fov", "not supported"});
  write("large.yml", "image_width: 640\nimage_height: 480\ncamera_matrix: [650,0,319.5,0,650,239.5,0,0,1]\n");
  check_fails(kInput, track({{"--camera", "large.yml"}}), {"640x480", "320x240", "--rescale-camera"});
  check_fails(kInput, {"simulate", "not_made", "--camera", "camera.yml", "--size", "640x480"}, {"640x480", "320x240"});
  write("sizeless.txt", "325 325 159.5 119.5\n");
  check_fails(kInput, track({{"--camera", "sizeless.txt"}, {"--rescale-camera", ""}}), {"no size", "--rescale-camera"});
  CHECK(inputs().run(track({{"--camera", "large.yml"}, {"--rescale-camera", ""}, {"--require-held", ""}})).exit_code ==
        kOk);
}

TEST_CASE("Poses") {
  check_fails(kInput, track({{"--init", "none.txt"}}), {"none.txt", "does not exist"});
  write("words.txt", "here be a pose\n");
  check_fails(kInput, track({{"--init", "words.txt"}}), {"words.txt", "line 1", "'here'"});
  write("twice.txt", "2 0 0 0 0 2 0 0 0 0 2 1\n");
  check_fails(kInput, track({{"--init", "twice.txt"}}), {"twice.txt", "rotation"});
  io::save_pose(inputs().folder() / "behind.txt", at(0, 0, -0.8));
  check_fails(kInput, track({{"--init", "behind.txt"}}), {"behind"});
  io::save_pose(inputs().folder() / "aside.txt", at(5, 0, 0.8));
  check_fails(kInput, track({{"--init", "aside.txt"}}), {"out of"});
}

TEST_CASE("Point pairs") {
  check_fails(kInput, init({{"--points", "none.csv"}}), {"none.csv", "do not exist"});
  write("columns.csv", "0,0,0,1\n");
  check_fails(kInput, init({{"--points", "columns.csv"}}), {"columns.csv", "line 1", "4 columns"});
  write("line.csv", "0,0,0,10,10\n.1,0,0,20,10\n.2,0,0,30,10\n.3,0,0,40,10\n");
  check_fails(kInput, init({{"--points", "line.csv"}}), {"one line"});
  write("three.csv", "0,0,0,10,10\n.1,0,0,20,10\n.2,.1,0,30,10\n");
  check_fails(kInput, init({{"--points", "three.csv"}}), {"3 different points"});
  write("four.csv", "0,0,0,10,10\n.1,0,0,20,10\n.2,.1,0,30,20\n.1,.1,.1,20,30\n");
  check_fails(kInput,
              init({{"--points", "four.csv"}, {"--camera", "(none)"}, {"--estimate-focal", ""}, {"--image", "frames"}}),
              {"4 different points", "6 or more"});
  check_fails(kUsage, init({{"--image", "frames"}, {"--frame", "7"}}), {"--frame 7", "frames"});
}

TEST_CASE("Videos and images") {
  check_fails(kInput, track({}, "none.mp4"), {"none.mp4"});
  write("text.mp4", "this is no video");
  check_fails(kInput, track({}, "text.mp4"), {"text.mp4"});
  fs::create_directory(inputs().folder() / "empty");
  check_fails(kInput, track({}, "empty"), {"empty"});
  fs::create_directory(inputs().folder() / "changing");
  for (int i = 0; i < 3; ++i) {
    const fs::path name = std::to_string(i) + ".png";
    const cv::Mat frame = cv::imread((inputs().folder() / "frames" / name).string());
    cv::imwrite((inputs().folder() / "changing" / name).string(), i < 2 ? frame : cv::Mat(frame.t()));
  }
  check_fails(kInput, track({{"--poses", "so_far.csv"}}, "changing"), {"240x320", "320x240"});
  const std::string poses = read_file(inputs().folder() / "so_far.csv");
  CHECK(std::count(poses.begin(), poses.end(), '\n') == 3);
}

TEST_CASE("No device, no renderer") {
  check_fails(kNoDevice, track({}), {"no OpenCL device", "pocl-opencl-icd"}, {{"OCL_ICD_VENDORS", "/nonexistent"}});
  // A platform without devices.
  check_fails(kNoDevice, track({}), {"no OpenCL device"},
              {{"OCL_ICD_VENDORS", "/etc/OpenCL/vendors/pocl.icd"}, {"POCL_DEVICES", "none"}});
  check_fails(kNoDevice, track({{"--device", "abacus"}}), {"abacus", "there is"});
  check_fails(kNoDevice, track({}), {"abacus", "HOLDFAST_DEVICE"}, {{"HOLDFAST_DEVICE", "abacus"}});
  check_fails(kNoDevice, {"devices"}, {"no OpenCL device"}, {{"OCL_ICD_VENDORS", "/nonexistent"}});
}

TEST_CASE("OSMesa draws; without it EGL does; without both, or what is asked for, one line says what to install") {
  const auto break_library = [](const std::string& folder, std::initializer_list<const char*> names) {
    fs::create_directory(inputs().folder() / folder);
    for (const char* name : names) write(folder + "/" + name, "no library");
    return Environment{{"LD_LIBRARY_PATH", (inputs().folder() / folder).string()}};
  };
  const Environment no_osmesa = break_library("no_osmesa", {"libOSMesa.so", "libOSMesa.so.6", "libOSMesa.so.8"});
  const Environment neither =
      break_library("neither", {"libOSMesa.so", "libOSMesa.so.6", "libOSMesa.so.8", "libEGL.so", "libEGL.so.1"});
  check_fails(kNoDevice, track({}), {"OSMesa", "EGL", "libosmesa6", "libegl1"}, neither);
  check_fails(kNoDevice, {"devices"}, {"OSMesa", "EGL", "libosmesa6", "libegl1"}, neither);
  check_fails(kNoDevice, track({{"--renderer", "osmesa"}}), {"OSMesa", "libosmesa6"}, no_osmesa);
  check_fails(kUsage, track({{"--renderer", "vulkan"}}), {"vulkan", "osmesa", "egl"});
  check_fails(kUsage, track({}), {"vulkan", "HOLDFAST_RENDERER"}, {{"HOLDFAST_RENDERER", "vulkan"}});

  const auto renderer = [](std::vector<std::string> arguments, const Environment& environment) {
    const ProgramRun run = inputs().run(arguments, environment);
    const std::size_t begin = run.out.find("Renderer");
    return begin == run.out.npos ? run.err : run.out.substr(begin, run.out.find('\n', begin + 10) - begin);
  };
  if (inputs().run({"devices", "--renderer", "egl"}).exit_code != kOk) {
    MESSAGE("EGL is not installed, so nothing can take over from OSMesa");
    return;
  }
  const std::string instead = renderer({"devices"}, no_osmesa);
  CHECK(instead.find("  EGL: ") != instead.npos);
  CHECK(instead.find("there is no OSMesa (") != instead.npos);
  CHECK(renderer({"devices"}, {{"HOLDFAST_RENDERER", "egl"}}).find("  EGL: ") != instead.npos);
  // The option comes before the variable.
  const std::string asked = renderer({"devices", "--renderer", "egl"}, {{"HOLDFAST_RENDERER", "osmesa"}});
  CHECK(asked.find("  EGL: ") != asked.npos);
  CHECK(asked.find("asked for") != asked.npos);
  CHECK(inputs().run(track({}), no_osmesa).exit_code == kOk);
}

TEST_CASE("Results that cannot be written") {
  check_fails(kOutput, track({{"--poses", "no/such/poses.csv"}}), {"no/such/poses.csv"});
  check_fails(kOutput, track({{"--poses", "/dev/full"}}), {"/dev/full", "space"});
  check_fails(kOutput, init({{"--pose", "no/such/pose.txt"}}), {"no/such/pose.txt"});
  check_fails(kOutput, init({{"--json", "/dev/full"}}), {"/dev/full", "space"});
  check_fails(kOutput, init({{"--picture", "check.nothing"}, {"--image", "frames/0.png"}}), {"check.nothing", ".png"});
}

TEST_CASE("A cache folder that cannot be written costs nothing but time") {
  const ProgramRun run = inputs().run(track({{"--cache-folder", "/proc/no/such"}}));
  CAPTURE(run.err);
  CHECK(run.exit_code == kOk);
  CHECK(run.err.empty());
}

TEST_CASE("An object that is lost in some frames is a failure only where it is asked for, one never held always is") {
  const fs::path noise = inputs().folder() / "noise", hidden = inputs().folder() / "hidden";
  fs::create_directory(noise);
  fs::copy(inputs().folder() / "frames", hidden);
  cv::theRNG().state = 1;
  for (int i = 0; i < 3; ++i) {
    cv::Mat picture(240, 320, CV_8UC3);
    cv::randu(picture, 0, 255);
    cv::imwrite((noise / (std::to_string(i) + ".png")).string(), picture);
    cv::imwrite((hidden / ("z" + std::to_string(i) + ".png")).string(), picture);
  }
  CHECK(inputs().run(track({}, "hidden")).exit_code == kOk);
  CHECK(inputs().run(track({{"--require-held", ""}}, "hidden")).exit_code == kLost);
  const ProgramRun never = inputs().run(track({}, "noise"));
  CHECK(never.exit_code == kLost);
  CHECK(never.err.find("not found where the first pose puts it") != never.err.npos);
  CHECK(never.err.find("held in no frame") != never.err.npos);
}
