#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "baking/texture_baker.hpp"
#include "holdfast/camera.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/pose.hpp"
#include "holdfast/tracker.hpp"

namespace holdfast::baking {

/// What textures a model gets.
struct TextureOptions {
  double texels_per_metre = 0;  ///< 0: as many as the camera has pixels on the nearest surface at the first pose
  int padding = 4;              ///< texels round each chart of an unwrapped mesh
  int largest_size = 4096;      ///< texels a side
  bool unwrap = false;          ///< anew, although the mesh has texture coordinates
  bool keep = false;            ///< what the model's textures know already stays
};

/// A baker for a mesh, which is unwrapped where it has no texture coordinates.
/// Throws Error(model, camera, renderer, invalid_argument).
TextureBaker make_baker(const Mesh& mesh, const Camera& camera, const Pose& T_camera_object,
                        const TextureOptions& textures, const BakeOptions& options);

/// A doubt, in one sentence, about the texture coordinates of a baker's model.
std::optional<std::string> coordinate_doubt(const TextureBaker& baker);

struct CompletionOptions {
  BakeOptions bake;
  TextureOptions textures;
  int opening_frames = 20;          ///< after the first one, that even out the noise of what it gave
  int every = 2;                    ///< after these, frames from one that is looked at to the next
  double least_correlation = 0.85;  ///< of rendered view and frame
  double least_used_share = 0.15;   ///< of the gradient pixels
  double largest_residual = 0.04;   ///< intensity in [0, 1]
  double least_news = 0.002;        ///< share of the surface that must have changed before the tracker gets it
};

/// A model that gains texture while it is tracked: what turns into view joins what is known. Build a tracker from
/// model(), and call update() after each frame.
class ModelCompletion {
 public:
  /// A model whose texture is kept goes on from what that knows; any other begins with what the first frame shows at
  /// the first pose. Throws Error(model, camera, renderer, image, pose); Error(pose) too when the frame shows nothing
  /// of the model at that pose.
  ModelCompletion(const Mesh& mesh, const Camera& camera, const cv::Mat& first_frame, const Pose& T_camera_object,
                  const CompletionOptions& options = {});

  /// The model with what is known now.
  Mesh model() const { return baker_.model(); }

  /// Takes what is new from the frame that the tracker was given last, where the pose is good enough for that, and
  /// gives the tracker the new texture when that is worth it. True when the frame was taken.
  bool update(Tracker& tracker, const cv::Mat& frame, const FrameResult& result);

  /// A doubt, in one sentence, about the model's texture coordinates.
  std::optional<std::string> doubt() const { return coordinate_doubt(baker_); }
  double first_coverage() const { return first_coverage_; }
  double coverage() const { return baker_.coverage(); }
  std::int64_t frames_taken() const { return frames_taken_; }

 private:
  bool is_trustworthy(const FrameResult& result) const;

  CompletionOptions options_;
  TextureBaker baker_;
  double first_coverage_ = 0;
  std::int64_t frames_ = 0;
  std::int64_t frames_taken_ = 0;
  double news_ = 0;  // texels that the tracker's texture lacks
};

}  // namespace holdfast::baking
