#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/export.hpp"
#include "holdfast/image_view.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/pose.hpp"

/// Files: the second library target, holdfast::io (OpenCV, assimp). Everything here throws Error with the file's name,
/// what is wrong in it and what to do.
namespace holdfast::io {

/// Reads a model file (OBJ, PLY, OFF, glTF 2.0, and what else assimp reads), its textures and colours; `scale` turns
/// the file's unit into metres. `remarks`, where given, gets a line for each thing in it that is missing or not
/// supported and without which the model can be used. Throws Error(file) or Error(model).
HOLDFAST_EXPORT Mesh load_model(const std::filesystem::path& path, double scale = 1.0,
                                std::vector<std::string>* remarks = nullptr);

/// The files that load_model() reads for this one: itself, and the material files, buffers and textures that it names,
/// as far as they are there. The file alone where it is no model.
HOLDFAST_EXPORT std::vector<std::filesystem::path> model_files(const std::filesystem::path& path);

/// Writes OBJ, MTL and one PNG a textured material (alpha kept), side by side. Throws Error(output), and
/// Error(invalid_argument) when the name does not end in .obj.
HOLDFAST_EXPORT void save_model(const std::filesystem::path& path, const Mesh& mesh);

/// Whether save_model() under the name `path` may write this file: the model, its materials or a texture, there or not.
HOLDFAST_EXPORT bool is_file_of_model(const std::filesystem::path& path, const std::filesystem::path& file);

/// The files, of those that are there already, that save_model() may replace under this name.
HOLDFAST_EXPORT std::vector<std::filesystem::path> replaceable_model_files(const std::filesystem::path& path);

/// A warning naming the likely unit when the object is under 1 mm or over 30 m (100 m where it is seen whole), or when,
/// seen at this pose, it is about 1000 times too large or too small for the picture; nothing when all is plausible.
HOLDFAST_EXPORT std::optional<std::string> unit_warning(const Mesh& mesh, const std::optional<Pose>& T_camera_object,
                                                        const std::optional<Camera>& camera);

/// Reads an OpenCV calibration (YAML, JSON, XML), a ROS camera_info YAML (its binning and region of interest applied),
/// Kalibr's chain of one camera, or "fx fy cx cy" text. Text has no size: width and height stay 0
/// until camera_for_frames(). Throws Error(file) or Error(camera), also for a lens model that is not supported.
HOLDFAST_EXPORT Camera load_camera(const std::filesystem::path& path);

/// Writes an OpenCV calibration file (format by the extension: .yml, .yaml, .json, .xml). Throws Error(output),
/// Error(invalid_argument) for another extension, and Error(camera) for a camera that could not be loaded again.
HOLDFAST_EXPORT void save_camera(const std::filesystem::path& path, const Camera& camera);

/// The camera for frames of this size: fills a missing size in; throws Error(camera) naming both sizes when they
/// differ, unless `rescale`, which needs a size of the same shape to scale from, and where the frames have no size.
HOLDFAST_EXPORT Camera camera_for_frames(const Camera& camera, int width, int height, bool rescale = false);

/// A warning where the focal length is no lens's for the frames, probably in another unit than pixels, or where the
/// principal point lies so far from their middle that the calibration is probably another picture's; nothing where both
/// are plausible or the camera has no size.
HOLDFAST_EXPORT std::optional<std::string> camera_warning(const Camera& camera);

/// Reads the first pose of a file: a 3x4 or 4x4 row-major matrix in any line layout, TUM (t tx ty tz qx qy qz qw), or
/// six numbers: OpenCV's rvec and tvec, in one line or two of three, or ViSP's translation and rotation in six lines.
/// Throws Error(file) or Error(pose).
HOLDFAST_EXPORT Pose load_pose(const std::filesystem::path& path);

/// All poses of a file, one a line (12 or 16 numbers, TUM's 8, or OpenCV's rvec and tvec).
HOLDFAST_EXPORT std::vector<Pose> load_poses(const std::filesystem::path& path);

struct TimedPose {
  std::optional<double> time_s;  ///< seconds, of a line in TUM's format
  Pose T_camera_object = Pose::Identity();
};

/// The same, with the times that stand in it.
HOLDFAST_EXPORT std::vector<TimedPose> load_timed_poses(const std::filesystem::path& path);

/// Writes a 4x4 matrix as text. Throws Error(output), and Error(pose) when it is not finite.
HOLDFAST_EXPORT void save_pose(const std::filesystem::path& path, const Pose& T_camera_object);

/// Looks at an encoded image before anything is decoded. Throws Error(file) where it is no picture of a known kind,
/// ends early, is a PNG whose sums are wrong, or has more than 67 million pixels. `name` is for the message.
HOLDFAST_EXPORT void check_image(const void* bytes, std::size_t size, const std::string& name);

/// By how many degrees to the right an encoded picture says (EXIF) that it must be turned to stand upright: 0, 90, 180
/// or 270. Holdfast takes pictures as they are stored.
HOLDFAST_EXPORT int image_turn(const void* bytes, std::size_t size);

/// An image file as RGBA; throws Error(file).
HOLDFAST_EXPORT Texture load_texture(const std::filesystem::path& path);

}  // namespace holdfast::io
