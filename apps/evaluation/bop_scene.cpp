#include "evaluation/bop_scene.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <stdexcept>

#include "evaluation/input_checks.hpp"
#include "holdfast/error.hpp"
#include "io/json_text.hpp"

namespace holdfast::evaluation {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kBopMetres = 1e-3;  // BOP's unit is the millimetre

json load_json(const fs::path& path) {
  std::ifstream in(path);
  if (!in) {
    bad_file(path, "cannot be opened");
  }
  try {
    return io::parse_json_text(std::string(std::istreambuf_iterator<char>(in), {}));
  } catch (const std::runtime_error& error) {
    bad_file(path, fmt::format("is no JSON that can be read: {}", error.what()));
  }
}

/// BOP's images are keyed by their number as text: in numerical order.
std::map<int, json> by_image(const json& object, const fs::path& path) {
  if (!object.is_object() || object.empty()) {
    bad_file(path, "holds no images");
  }
  std::map<int, json> images;
  for (const auto& [key, value] : object.items()) {
    if (key.empty() || key.size() > 9 || key.find_first_not_of("0123456789") != std::string::npos) {
      bad_file(path, fmt::format("'{}' is no image number", key));
    }
    images[std::stoi(key)] = value;
  }
  return images;
}

std::vector<double> numbers(const json& entry, const char* key, std::size_t count, const fs::path& path, int image) {
  if (!entry.is_object() || !entry.contains(key) || !entry[key].is_array() || entry[key].size() != count ||
      !std::all_of(entry[key].begin(), entry[key].end(), [](const json& value) { return value.is_number(); })) {
    bad_file(path, fmt::format("image {}: {} must be {} numbers", image, key, count));
  }
  return entry[key].get<std::vector<double>>();
}

Pose bop_pose(const json& entry, const fs::path& path, int image) {
  const std::vector<double> rotation = numbers(entry, "cam_R_m2c", 9, path, image);
  const std::vector<double> translation = numbers(entry, "cam_t_m2c", 3, path, image);
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotation.data());
  pose.translation() = Eigen::Map<const Eigen::Vector3d>(translation.data()) * kBopMetres;
  return checked(pose, path, fmt::format("image {}", image));
}

int bop_object_id(const json& entry, const fs::path& path, int image) {
  if (!entry.is_object() || !entry.contains("obj_id") || !entry["obj_id"].is_number_integer()) {
    bad_file(path, fmt::format("image {}: an entry has no obj_id", image));
  }
  return entry["obj_id"].get<int>();
}

fs::path bop_image(const fs::path& folder, int image) {
  for (const char* kind : {"rgb", "gray"}) {
    for (const char* extension : {"png", "jpg", "tif"}) {
      const fs::path path = folder / kind / fmt::format("{:06}.{}", image, extension);
      if (fs::exists(path)) {
        return path;
      }
    }
  }
  bad_file(folder, fmt::format("no image {:06} in rgb/ or gray/ though scene_gt.json has its pose", image));
}

}  // namespace

void load_bop_scene(Sequence& sequence, std::optional<int> wanted) {
  sequence.model_scale = kBopMetres;
  const fs::path truth_file = sequence.folder / "scene_gt.json";
  const fs::path camera_path = sequence.folder / "scene_camera.json";
  const fs::path info_path = sequence.folder / "scene_gt_info.json";
  const std::map<int, json> truth = by_image(load_json(truth_file), truth_file);
  const std::map<int, json> cameras = by_image(load_json(camera_path), camera_path);
  std::map<int, json> infos;
  sequence.tables = {truth_file, camera_path};
  if (fs::exists(info_path)) {
    infos = by_image(load_json(info_path), info_path);
    sequence.tables.push_back(info_path);
  }
  const bool has_images = fs::is_directory(sequence.folder / "rgb") || fs::is_directory(sequence.folder / "gray");

  if (!wanted) {
    std::set<int> objects;
    for (const auto& [image, entries] : truth) {
      for (const json& entry : entries) {
        objects.insert(bop_object_id(entry, truth_file, image));
      }
    }
    if (objects.size() != 1) {
      bad_file(truth_file, fmt::format("holds {} objects: choose one with --bop-object", objects.size()));
    }
    wanted = *objects.begin();
  }

  std::vector<double> first_k;
  for (const auto& [image, entries] : truth) {
    if (!entries.is_array()) {
      bad_file(truth_file, fmt::format("image {} has no list of poses", image));
    }
    int found = -1;
    for (std::size_t i = 0; i < entries.size(); ++i) {
      if (bop_object_id(entries[i], truth_file, image) == *wanted) {
        if (found >= 0) {
          bad_file(truth_file, fmt::format("image {} holds object {} more than once", image, *wanted));
        }
        found = static_cast<int>(i);
      }
    }
    if (found < 0) {
      bad_file(truth_file, fmt::format("image {} has no pose of object {}", image, *wanted));
    }
    const auto camera = cameras.find(image);
    if (camera == cameras.end()) {
      bad_file(camera_path, fmt::format("no camera for image {} of scene_gt.json", image));
    }
    const std::vector<double> k = numbers(camera->second, "cam_K", 9, camera_path, image);
    if (k[1] != 0 || k[3] != 0) {
      bad_file(camera_path, fmt::format("image {}: cam_K has a skew; only cameras without are supported", image));
    }
    if (first_k.empty()) {
      first_k = k;
    } else if (!std::equal(k.begin(), k.end(), first_k.begin(),
                           [](double a, double b) { return std::abs(a - b) <= 1e-3; })) {
      bad_file(camera_path,
               fmt::format("image {} has another cam_K than the first: the tracker follows one camera", image));
    }
    sequence.truth.push_back(bop_pose(entries[found], truth_file, image));
    if (const auto info = infos.find(image); info != infos.end()) {
      const json& entry = info->second.is_array() && static_cast<std::size_t>(found) < info->second.size()
                              ? info->second[found]
                              : json();
      if (!entry.is_object() || !entry.contains("visib_fract") || !entry["visib_fract"].is_number()) {
        bad_file(info_path, fmt::format("image {}: no visib_fract for object {}", image, *wanted));
      }
      sequence.visible.push_back(entry["visib_fract"].get<double>());
    }
    if (has_images) {
      sequence.frames.push_back(bop_image(sequence.folder, image));
    }
  }
  if (cameras.size() != truth.size()) {
    throw Error(ErrorCode::file,
                fmt::format("{}: {} images in scene_camera.json but {} in scene_gt.json; one pose a frame is needed",
                            sequence.folder.string(), cameras.size(), truth.size()));
  }
  // DATASET/SPLIT/SCENE and DATASET/models.
  const fs::path model = fs::weakly_canonical(sequence.folder).parent_path().parent_path() / "models" /
                         fmt::format("obj_{:06}.ply", *wanted);
  if (fs::exists(model)) {
    sequence.model = model;
  }
  sequence.camera.fx = first_k[0];
  sequence.camera.fy = first_k[4];
  sequence.camera.cx = first_k[2];
  sequence.camera.cy = first_k[5];
}

}  // namespace holdfast::evaluation
