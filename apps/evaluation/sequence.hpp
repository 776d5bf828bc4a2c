#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/pose.hpp"

namespace holdfast::evaluation {

/// A recorded sequence with ground truth.
struct Sequence {
  std::string name;                           ///< the folder's name
  std::filesystem::path folder;               ///< as given
  std::vector<std::filesystem::path> frames;  ///< image files in order; empty where the folder has none
  std::vector<Pose> truth;                    ///< T_camera_object, one a frame
  /// Grey images, bright where a pixel shows an occluder, one a frame; empty: not known.
  std::vector<std::filesystem::path> occluder_masks;
  std::vector<std::filesystem::path> tables;  ///< files that the rest was read from
  std::vector<double> visible;                ///< visible share of the silhouette, one a frame; empty: not known
  Camera camera;                              ///< of the frames; size 0 where there are no frames
  std::filesystem::path model;                ///< the one that comes with the sequence; empty: none
  double model_scale = 1;                     ///< turns the unit of the models that belong to this format into metres
};

/// Reads a folder of either layout:
/// - frames/ (images in the order of their names), K.txt or camera.yml/.yaml/.json/.xml, poses_gt.txt (a line a frame,
///   metres) and, where known, visible.txt (a share a line), masks/ (where occluders are seen, an image a frame) and
///   model/model.obj;
/// - a BOP scene: scene_camera.json, scene_gt.json, rgb/ or gray/, scene_gt_info.json where there is one (millimetres,
///   turned into metres here), and the object's model in models/ two folders up. `bop_object` picks the object;
///   without it the scene must hold one object only.
/// Throws Error(file), Error(pose), Error(camera) or Error(image): one line that names the file.
Sequence load_sequence(const std::filesystem::path& folder, std::optional<int> bop_object = std::nullopt);

}  // namespace holdfast::evaluation
