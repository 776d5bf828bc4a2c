#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/export.hpp"
#include "holdfast/frame_result.hpp"
#include "holdfast/image_view.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/pose.hpp"
#include "holdfast/tracker.hpp"

/// Finds an object without a pose to start from: the third library target, holdfast::detection (OpenCV).
namespace holdfast::detection {

/// Local features (SIFT) of a textured model and their places on it, from views of all sides. Copies share them.
class HOLDFAST_EXPORT ModelFeatures {
 public:
  /// Draws the views. Throws Error(model) for a mesh without texture and colours or whose look has next to no features,
  /// Error(renderer).
  explicit ModelFeatures(const Mesh& mesh);
  /// What save() wrote for the same mesh. Throws Error(file) for what cannot be read, is damaged or of another model.
  static ModelFeatures load(const std::filesystem::path& path, const Mesh& mesh);
  /// Throws Error(output).
  void save(const std::filesystem::path& path) const;
  /// The features kept in this file; where there is none they are made and written to it. Throws as the others.
  static ModelFeatures kept_in(const std::filesystem::path& path, const Mesh& mesh);

  /// None yet, of a mesh with or without a look of its own; a SightLearner adds to them.
  static ModelFeatures none(const Mesh& mesh);
  /// These and another's of the same mesh. Throws Error(invalid_argument) for another mesh's.
  ModelFeatures with(const ModelFeatures& other) const;

  std::size_t count() const;

  struct Data;
  explicit ModelFeatures(std::shared_ptr<const Data> data) : data_(std::move(data)) {}
  const Data& data() const { return *data_; }

 private:
  std::shared_ptr<const Data> data_;
};

/// Hash of all that a mesh shows, 32 hexadecimal digits: the name that its features are kept under.
HOLDFAST_EXPORT std::string model_hash(const Mesh& mesh);

/// A pose that features or gradients of a frame agree on.
struct PoseCandidate {
  Pose T_camera_object = Pose::Identity();
  int matches = 0;   ///< features of the frame that look like one of the model
  int inliers = 0;   ///< of these, that this pose explains
  double score = 0;  ///< how well gradients agree with the model's contour, at most 1
};

/// Proposes poses of an object in single frames of one camera. Used by one thread at a time.
class HOLDFAST_EXPORT Detector {
 public:
  /// Throws Error(camera), and Error(model) for features of next to nothing, as those of none() are.
  Detector(const ModelFeatures& features, const Camera& camera);
  ~Detector();
  Detector(Detector&&) noexcept;
  Detector& operator=(Detector&&) noexcept;

  /// Poses to look closer at, the most probable first; none where nothing looks like the object. Throws Error(image)
  /// for a frame of another size than the camera's.
  std::vector<PoseCandidate> detect(const ImageView& frame) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Learns from frames what an object really looks like: features of its surface, at the places that the mesh has there,
/// so that an object whose mesh has no texture, or not that of today's light, is recognized next time. Used by one
/// thread at a time.
class HOLDFAST_EXPORT SightLearner {
 public:
  /// `known`: features that the object is recognized by anyway; `seen`: what was learned before. Throws Error(camera,
  /// renderer), Error(model) for a mesh that cannot be drawn.
  SightLearner(const Mesh& mesh, const Camera& camera, const ModelFeatures& known, const ModelFeatures& seen);
  ~SightLearner();
  SightLearner(SightLearner&&) noexcept;
  SightLearner& operator=(SightLearner&&) noexcept;

  /// Looks at a frame that the object is held in. What it shows is learned where it shows a side that features known so
  /// far do not tell the pose of, and hides little of it; true then. Takes a tenth of a second for each new side, next
  /// to nothing otherwise. Throws Error(image) for a frame of another size.
  bool look(const ImageView& frame, const FrameResult& result);

  /// Everything learned, before and since.
  const ModelFeatures& seen() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

struct FocalEstimate {
  double focal = 0;  ///< pixels
  double sigma = 0;  ///< its standard deviation, pixels
  int frames = 0;    ///< that show the object
};

/// Estimates the focal length of an unknown camera from frames of the object: square pixels, the principal point near
/// the middle, little lens distortion, a model whose shape and texture are right to some percent; what these may be off
/// by is in the deviation. Frames that show it near and at a slant tell most. Used by one thread at a time.
class HOLDFAST_EXPORT FocalEstimator {
 public:
  /// Throws Error(camera) for a size that is not positive.
  FocalEstimator(const ModelFeatures& features, int width, int height);
  ~FocalEstimator();
  FocalEstimator(FocalEstimator&&) noexcept;
  FocalEstimator& operator=(FocalEstimator&&) noexcept;

  /// Whether the frame shows the object. Throws Error(image) for a frame of another size.
  bool add(const ImageView& frame);
  /// From the frames added so far; nothing while fewer than three of them show the object.
  std::optional<FocalEstimate> estimate() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Proposes poses near a guide, an object about as it will be held: up to 20 degrees, a fifth of its distance and a
/// quarter of the picture off. Looks for gradients along the model's contour and sharp edges, so that it needs no
/// texture. Used by one thread at a time.
class HOLDFAST_EXPORT GuideDetector {
 public:
  /// Throws Error(camera, renderer), Error(model) for a mesh that cannot be drawn, Error(pose) for a guide that is no
  /// rigid motion or puts the object behind the camera or out of the picture.
  GuideDetector(const Mesh& mesh, const Camera& camera, const Pose& T_guide);
  ~GuideDetector();
  GuideDetector(GuideDetector&&) noexcept;
  GuideDetector& operator=(GuideDetector&&) noexcept;

  /// The places that fit best, the best first, whether the object is there or not: start_near() tells. Throws as
  /// Detector::detect().
  std::vector<PoseCandidate> detect(const ImageView& frame) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Refines the candidates in this frame and judges them: the result of the first one that surely is the object, from
/// which the tracker then goes on with the next frame; nothing where none is, and the tracker is as it was. `time_s`:
/// as Tracker::track(). Throws as Tracker::refine().
HOLDFAST_EXPORT std::optional<FrameResult> start_at(Tracker& tracker, const std::vector<PoseCandidate>& candidates,
                                                    const ImageView& frame, std::optional<double> time_s = {});

/// The same for candidates of a guide, of which the contour may tell enough. The tracker forgets what it has learned.
/// The object is seen, not surely there: it is, when is_still_seen() holds for the next two frames too.
HOLDFAST_EXPORT std::optional<FrameResult> start_near(Tracker& tracker, const std::vector<PoseCandidate>& candidates,
                                                      const ImageView& frame, std::optional<double> time_s = {});

/// The same for candidates by features that frames have shown of an object whose mesh has no look (SightLearner): many
/// agree, and the contour holds there. The tracker forgets what it has learned.
HOLDFAST_EXPORT std::optional<FrameResult> start_seen(Tracker& tracker, const std::vector<PoseCandidate>& candidates,
                                                      const ImageView& frame, std::optional<double> time_s = {});

/// A frame's result is enough, by its texture or by its contour and edges, to go on with a start near a guide.
HOLDFAST_EXPORT bool is_still_seen(const FrameResult& result);

}  // namespace holdfast::detection
