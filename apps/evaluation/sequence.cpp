#include "evaluation/sequence.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <sstream>
#include <type_traits>

#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "video/image_list.hpp"

namespace holdfast::evaluation {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kBopMetres = 1e-3;  // BOP's unit is the millimetre

[[noreturn]] void bad_file(const fs::path& path, const std::string& what) {
  throw Error(ErrorCode::file, fmt::format("{}: {}", path.string(), what));
}

std::vector<fs::path> images_in(const fs::path& folder) {
  std::vector<fs::path> images;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.is_regular_file() && app::is_image_name(entry.path())) {
      images.push_back(entry.path());
    }
  }
  std::sort(images.begin(), images.end());
  return images;
}

cv::Size image_size(const fs::path& path) {
  const cv::Mat image = cv::imread(path.string(), cv::IMREAD_UNCHANGED);
  if (image.empty()) {
    bad_file(path, "not a readable image");
  }
  return image.size();
}

/// Poses are kept as exact rotations; what is no rotation at all is refused with the place it stands at.
Pose checked(const Pose& pose, const fs::path& path, const std::string& where) {
  try {
    validate_pose(pose);
  } catch (const Error& error) {
    throw Error(ErrorCode::pose, fmt::format("{}, {}: {}", path.string(), where, error.what()));
  }
  return renormalized(pose);
}

std::vector<double> load_shares(const fs::path& path) {
  std::ifstream in(path);
  if (!in) {
    bad_file(path, "cannot be opened");
  }
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

void check_counts(const Sequence& sequence, const fs::path& truth_file) {
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
    if (sequence.frames.empty()) {
      bad_file(frames, "holds no images");
    }
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
  check_counts(sequence, truth_file);
  complete_camera(sequence);
}

/// Levels of lists and objects within each other that BOP's files have not nearly; more would run out of stack.
constexpr int kMostNested = 64;

json load_json(const fs::path& path) {
  std::ifstream in(path);
  if (!in) {
    bad_file(path, "cannot be opened");
  }
  const auto not_too_deep = [&path](int depth, json::parse_event_t, json&) {
    if (depth > kMostNested) bad_file(path, "is nested too deeply");
    return true;
  };
  try {
    return json::parse(in, not_too_deep);
  } catch (const json::exception& error) {
    bad_file(path, fmt::format("is not valid JSON: {}", error.what()));
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

void load_bop(Sequence& sequence, std::optional<int> wanted) {
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
  check_counts(sequence, truth_file);
  complete_camera(sequence);
}

/// The cells of a line of a table; one in quotes may hold commas, and quotes twice.
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') {
      if (quoted && i + 1 < line.size() && line[i + 1] == '"') {
        cells.back() += line[++i];
      } else {
        quoted = !quoted;
      }
    } else if (line[i] == ',' && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += line[i];
    }
  }
  for (std::string& cell : cells) {
    const auto from = cell.find_first_not_of(" \t\r");
    const auto to = cell.find_last_not_of(" \t\r");
    cell = from == std::string::npos ? std::string() : cell.substr(from, to - from + 1);
  }
  return cells;
}

double number(const std::string& text, const fs::path& path, int line) {
  try {
    std::size_t used = 0;
    const double value = std::stod(text, &used);
    if (used == text.size()) {
      return value;
    }
  } catch (const std::exception&) {
  }
  bad_file(path, fmt::format("line {}: '{}' is no number", line, text));
}

/// Over the mark that Windows' programs begin UTF-8 with.
void skip_byte_order_mark(std::ifstream& file) {
  char mark[3] = {};
  file.read(mark, sizeof(mark));
  if (std::string_view(mark, static_cast<std::size_t>(file.gcount())) != "\xef\xbb\xbf") {
    file.clear();
    file.seekg(0);
  }
}

/// The table that `holdfast track --poses` writes.
EstimatedPoses load_table(const fs::path& path) {
  std::ifstream in(path);
  skip_byte_order_mark(in);
  std::string line;
  std::getline(in, line);
  std::map<std::string, std::size_t> column;
  for (const std::string& name : cells_of(line)) {
    column.emplace(name, column.size());
  }
  for (const char* name : {"frame", "tx", "ty", "tz", "qx", "qy", "qz", "qw"}) {
    if (!column.contains(name)) {
      bad_file(path,
               fmt::format("no column '{}': a table with frame, tx ty tz (metres) and qx qy qz qw is needed", name));
    }
  }
  EstimatedPoses out;
  for (int number_of_line = 2; std::getline(in, line); ++number_of_line) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) {
      continue;
    }
    const std::vector<std::string> cells = cells_of(line);
    const auto cell = [&](const char* name) -> const std::string& {
      if (column.at(name) >= cells.size()) {
        bad_file(path, fmt::format("line {}: {} columns where the heading has {}", number_of_line, cells.size(),
                                   column.size()));
      }
      return cells[column.at(name)];
    };
    const auto value = [&](const char* name) { return number(cell(name), path, number_of_line); };
    EstimatedPoses::Entry entry;
    entry.frame = static_cast<int>(value("frame"));
    if (!out.entries.empty() && entry.frame <= out.entries.back().frame) {
      bad_file(path, fmt::format("line {}: frame {} does not come after frame {}", number_of_line, entry.frame,
                                 out.entries.back().frame));
    }
    const Eigen::Quaterniond q(value("qw"), value("qx"), value("qy"), value("qz"));
    if (!(std::abs(q.norm() - 1) < 1e-3)) {
      throw Error(ErrorCode::pose, fmt::format("{}, line {}: the quaternion's length is {:.6g}, a rotation's is 1",
                                               path.string(), number_of_line, q.norm()));
    }
    FrameResult& result = entry.result;
    result.T_camera_object.linear() = q.normalized().toRotationMatrix();
    result.T_camera_object.translation() = Eigen::Vector3d(value("tx"), value("ty"), value("tz"));
    checked(result.T_camera_object, path, fmt::format("line {}", number_of_line));
    result.status = Status::held;
    if (column.contains("status")) {
      const std::string& status = cell("status");
      if (status != "held" && status != "lost") {
        bad_file(path, fmt::format("line {}: status '{}' is neither held nor lost", number_of_line, status));
      }
      result.status = status == "held" ? Status::held : Status::lost;
    }
    const auto figure = [&](const char* name, auto& field) {
      if (column.contains(name)) field = static_cast<std::remove_reference_t<decltype(field)>>(value(name));
    };
    figure("visible", result.texture.visible_pixels);
    figure("usable", result.texture.usable_pixels);
    figure("gradient", result.texture.gradient_pixels);
    figure("passed", result.texture.passed_pixels);
    figure("used", result.texture.used_pixels);
    figure("residual", result.texture.residual);
    figure("correlation", result.texture.correlation);
    result.texture.asked = column.contains("visible");
    figure("iterations", result.iterations);
    figure("ms", result.ms.total);
    figure("texture_holds", result.texture.holds);
    figure("contour_holds", result.contour.holds);
    figure("snapshot_holds", result.snapshot.holds);
    if (column.contains("reason")) {
      result.message = cell("reason");
    }
    out.entries.push_back(entry);
  }
  return out;
}

/// The frame that is shown at this time: files have rounded times, but none between frames.
int frame_at(double time_s, double frame_rate, const fs::path& path) {
  constexpr double kBeside = 0.1;
  const double frame = std::round(time_s * frame_rate);
  if (!(std::abs(frame - time_s * frame_rate) < kBeside && frame >= 0 && frame <= std::numeric_limits<int>::max())) {
    bad_file(path,
             fmt::format("the time {:.6g} s is none of a frame at {:g} frames a second, counted from the first; give "
                         "the table of 'holdfast track --poses', which has frames' numbers, or the numbers as times",
                         time_s, frame_rate));
  }
  return static_cast<int>(frame);
}

/// A pose a line.
EstimatedPoses load_lines(const fs::path& path, std::optional<double> frame_rate) {
  const std::vector<io::TimedPose> lines = io::load_timed_poses(path);
  const bool timed =
      frame_rate && std::all_of(lines.begin(), lines.end(), [](const io::TimedPose& line) { return line.time_s; });
  const bool numbered = std::all_of(lines.begin(), lines.end(), [](const io::TimedPose& line) {
    return line.time_s && *line.time_s == std::round(*line.time_s);
  });
  EstimatedPoses out;
  for (const io::TimedPose& line : lines) {
    const int last = out.entries.empty() ? -1 : out.entries.back().frame;
    const int frame = timed ? frame_at(*line.time_s, numbered ? 1 : *frame_rate, path) : last + 1;
    if (frame <= last)
      bad_file(path, fmt::format("the time {:.6g} s does not come after the one before", *line.time_s));
    out.entries.push_back({frame, {}});
    out.entries.back().result.T_camera_object = line.T_camera_object;
    out.entries.back().result.status = Status::held;
  }
  return out;
}

/// Without a slash at its end, which would make the last name empty.
fs::path whole_path(const fs::path& folder) {
  const fs::path path = fs::weakly_canonical(folder);
  return path.has_filename() ? path : path.parent_path();
}

/// The last `parts` names of a path, joined.
std::string name_of(const fs::path& folder, int parts) {
  fs::path rest = whole_path(folder);
  std::string name = rest.filename().string();
  for (int i = 1; i < parts && rest.has_parent_path(); ++i) {
    rest = rest.parent_path();
    name = rest.filename().string() + "_" + name;
  }
  return name;
}

}  // namespace

std::vector<std::string> distinct_names(const std::vector<fs::path>& folders) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < folders.size(); ++i) {
    const fs::path whole = whole_path(folders[i]);
    // As few of the folders above as tell it from every other folder.
    int parts = 1;
    for (const fs::path& other : folders) {
      if (whole_path(other) == whole) continue;
      while (name_of(other, parts) == name_of(whole, parts)) ++parts;
    }
    const std::string name = name_of(whole, parts);
    names.push_back(name);
    for (int again = 2; std::count(names.begin(), names.end(), names.back()) > 1; ++again) {
      names.back() = fmt::format("{}_{}", name, again);
    }
  }
  return names;
}

Sequence load_sequence(const fs::path& folder, std::optional<int> bop_object) {
  if (!fs::is_directory(folder)) {
    bad_file(folder, "no such folder");
  }
  Sequence sequence;
  sequence.folder = folder;
  sequence.name = name_of(folder, 1);
  if (fs::exists(folder / "scene_gt.json") || fs::exists(folder / "scene_camera.json")) {
    load_bop(sequence, bop_object);
  } else if (fs::exists(folder / "poses_gt.txt")) {
    if (bop_object) {
      bad_file(folder, "no BOP scene, which is what --bop-object chooses in: leave it out");
    }
    load_plain(sequence);
  } else {
    bad_file(folder, "no sequence: neither poses_gt.txt (with frames/ and K.txt) nor scene_gt.json (BOP) is there");
  }
  return sequence;
}

EstimatedPoses load_estimated_poses(const fs::path& file, std::optional<double> frame_rate) {
  std::ifstream in(file);
  if (!in) {
    bad_file(file, "cannot be opened");
  }
  std::string first;
  std::getline(in, first);
  const bool table = first.find("frame") != std::string::npos && first.find(',') != std::string::npos;
  EstimatedPoses out = table ? load_table(file) : load_lines(file, frame_rate);
  if (out.entries.empty()) {
    bad_file(file, "holds no poses");
  }
  return out;
}

}  // namespace holdfast::evaluation
