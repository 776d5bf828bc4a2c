#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/pose.hpp"
#include "holdfast/tracker.hpp"

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

/// Names under which the results of these folders can stand beside each other: a folder's own where no other has it,
/// else with those of the folders above that tell it apart, or a number where it is the same folder again.
std::vector<std::string> distinct_names(const std::vector<std::filesystem::path>& folders);

/// Poses as a program wrote them: the table of `holdfast track` (columns frame, status, tx ty tz qx qy qz qw), or text
/// with a pose a line (12 or 16 numbers, or TUM).
struct EstimatedPoses {
  struct Entry {
    int frame = 0;
    FrameResult result;  ///< as far as the file tells; held where it does not

    bool held() const { return result.status == Status::held; }
  };
  std::vector<Entry> entries;  ///< by rising frame
};

/// Times of TUM lines tell the frame where `frame_rate` (frames a second) is given, unless all are whole numbers, which
/// are taken for frames themselves; otherwise a line is a frame. Throws Error(file) or Error(pose).
EstimatedPoses load_estimated_poses(const std::filesystem::path& file, std::optional<double> frame_rate);

}  // namespace holdfast::evaluation
