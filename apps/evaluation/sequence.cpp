#include "evaluation/sequence.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "evaluation/bop_scene.hpp"
#include "evaluation/folder_names.hpp"
#include "evaluation/input_checks.hpp"
#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "video/image_list.hpp"

namespace holdfast::evaluation {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> images_in(const fs::path& folder) {
  std::vector<fs::path> images;
  std::optional<std::vector<app::ListedImage>> listed = app::list_images(folder.string());
  for (app::ListedImage& image : *listed) images.push_back(std::move(image.path));
  return images;
}

cv::Size image_size(const fs::path& path) {
  const cv::Mat image = cv::imread(path.string(), cv::IMREAD_UNCHANGED);
  if (image.empty()) {
    bad_file(path, "not a readable image");
  }
  return image.size();
}

std::vector<double> load_shares(const fs::path& path) {
  std::ifstream in(path);
  if (!in) {
    bad_file(path, "cannot be opened");
  }
  skip_byte_order_mark(in);
  std::vector<double> shares;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) {
      continue;
    }
    std::istringstream text(line);
    double share = 0;
    if (!(text >> share) || !(share >= 0 && share <= 1)) {
      bad_file(path, fmt::format("line {}: '{}' is no share between 0 and 1", number, line));
    }
    shares.push_back(share);
  }
  return shares;
}

fs::path camera_file(const fs::path& folder) {
  // K.txt has no room for a lens: beside a calibration it says less.
  static constexpr std::array names = {"camera.yml", "camera.yaml", "camera.json", "camera.xml", "K.txt"};
  for (const char* name : names) {
    if (fs::exists(folder / name)) {
      return folder / name;
    }
  }
  bad_file(folder, "no camera: K.txt (fx fy cx cy) or camera.yml is needed");
}

void check_counts(const Sequence& sequence) {
  const fs::path& truth_file = sequence.tables.front();
  if (sequence.truth.empty()) {
    bad_file(truth_file, "holds no poses");
  }
  if (!sequence.frames.empty() && sequence.frames.size() != sequence.truth.size()) {
    throw Error(ErrorCode::file, fmt::format("{}: {} frames but {} true poses in {}; one pose a frame is needed",
                                             sequence.folder.string(), sequence.frames.size(), sequence.truth.size(),
                                             truth_file.filename().string()));
  }
  if (!sequence.visible.empty() && sequence.visible.size() != sequence.truth.size()) {
    throw Error(ErrorCode::file, fmt::format("{}: {} visible shares but {} true poses in {}; one a frame is needed",
                                             sequence.folder.string(), sequence.visible.size(), sequence.truth.size(),
                                             truth_file.filename().string()));
  }
}

void complete_camera(Sequence& sequence) {
  if (!sequence.frames.empty()) {
    const cv::Size size = image_size(sequence.frames.front());
    sequence.camera = io::camera_for_frames(sequence.camera, size.width, size.height, false);
  }
}

void load_plain(Sequence& sequence) {
  const fs::path truth_file = sequence.folder / "poses_gt.txt";
  sequence.truth = io::load_poses(truth_file);
  sequence.tables.push_back(truth_file);
  const fs::path frames = sequence.folder / "frames";
  if (fs::is_directory(frames)) {
    sequence.frames = images_in(frames);
    sequence.tables.push_back(camera_file(sequence.folder));
    sequence.camera = io::load_camera(sequence.tables.back());
  }
  const fs::path model = sequence.folder / "model" / "model.obj";
  if (fs::exists(model)) {
    sequence.model = model;
  }
  const fs::path visible = sequence.folder / "visible.txt";
  if (fs::exists(visible)) {
    sequence.visible = load_shares(visible);
    sequence.tables.push_back(visible);
  }
  const fs::path masks = sequence.folder / "masks";
  if (fs::is_directory(masks)) {
    sequence.occluder_masks = images_in(masks);
    if (sequence.occluder_masks.size() != sequence.truth.size()) {
      bad_file(masks, fmt::format("{} images but {} true poses in poses_gt.txt; one a frame is needed",
                                  sequence.occluder_masks.size(), sequence.truth.size()));
    }
  }
}

}  // namespace

Sequence load_sequence(const fs::path& folder, std::optional<int> bop_object) {
  if (!fs::is_directory(folder)) {
    bad_file(folder, "no such folder");
  }
  Sequence sequence;
  sequence.folder = folder;
  sequence.name = folder_name(folder);
  if (fs::exists(folder / "scene_gt.json") || fs::exists(folder / "scene_camera.json")) {
    load_bop_scene(sequence, bop_object);
  } else if (fs::exists(folder / "poses_gt.txt")) {
    if (bop_object) {
      bad_file(folder, "no BOP scene, which is what --bop-object chooses in: leave it out");
    }
    load_plain(sequence);
  } else {
    bad_file(folder, "no sequence: neither poses_gt.txt (with frames/ and K.txt) nor scene_gt.json (BOP) is there");
  }
  check_counts(sequence);
  complete_camera(sequence);
  return sequence;
}

}  // namespace holdfast::evaluation
