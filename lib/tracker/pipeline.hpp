#pragma once

#include <functional>
#include <optional>

#include "base/tuning.hpp"
#include "imaging/lit_patches.hpp"
#include "judge/judge.hpp"
#include "recovery/outline_search.hpp"
#include "recovery/relocalizer.hpp"
#include "recovery/snapshot_album.hpp"
#include "tracker/aligner.hpp"
#include "tracker/tracking_state.hpp"

namespace holdfast {

/// Uploads the part of the frame at hand that a region needs.
using UploadFrame = std::function<void(const Rect& region)>;

/// One object through the frames of one camera: predict, align, judge, relocalize, commit (docs/architecture.md).
class Pipeline {
 public:
  Pipeline(const Mesh& mesh, const Camera& camera, const Tuning& tuning, const Device& device, Renderer renderer);

  /// Starts at this pose, at rest.
  void reset(const Pose& T_camera_object);
  /// The same, shown the frame that the pose holds in.
  void reset(const Pose& T_camera_object, const UploadFrame& upload, std::optional<double> time);
  bool started() const { return started_; }

  FrameResult track(const UploadFrame& upload, std::optional<double> time);
  FrameResult refine(const UploadFrame& upload, const Pose& T_camera_object);

  PixelMask pixel_mask();
  RenderedView rendered_view();
  void set_texture(std::size_t material, const Texture& texture);

  ViewTemplate& view() { return view_; }
  DeviceImage& image() { return image_; }
  const Extent& extent() const { return extent_; }

 private:
  /// Throws Error(invalid_argument) for a time that does not come after the last frame's, or that only some have.
  double frame_time(std::optional<double> time);
  void choose_finest_level();
  void upload(const Rect& wanted, int margin);
  /// A pose that a frame is to be learned from: a proposal, a first pose, or one that is right.
  enum class Given { roughly, nearly, exactly };
  /// Learns light, colours and, at a pose that is right, what is usual, from the frame at hand.
  void see(const Pose& T_camera_object, Given given, TrackingState& state);
  /// In the first frames, texture that does not fit may not be what frames show: outline and snapshot then lead to
  /// where it is asked again.
  void doubt_texture(Alignment& best);
  /// The snapshot becomes what frames are compared with.
  void show(const Snapshot& snapshot, TrackingState& state);
  /// Whether a pose that the outline alone holds, with nothing in front of it, has the model's print on it.
  void look_for_print(const Alignment& alignment);
  /// The pose at which a model starts whose own edges are not found, while the frame has others that go along with
  /// them: they are followed instead. The given pose is taken at its word, unless the aligned one finds far more
  /// edges. None where the frame has no such edges.
  std::optional<Pose> start_as_given(const Pose& T_given, const Pose& T_aligned);

  Alignment follow(const MotionPrior& prior);
  bool follow_from_there(Alignment& best, TrackingState& state);
  std::optional<Alignment> follow_directly(const MotionPrior& prior);
  Alignment follow_fully(const std::vector<Pose>& hypotheses, bool search, const TrackingState& state);
  Alignment follow_once(const Pose& T_start, const TrackingState& state);
  std::vector<Pose> hypotheses(const MotionPrior& prior) const;
  void relocalize(const MotionPrior& prior, Alignment& best);
  /// Frames after a loss in which an object is looked for near where it would be.
  static constexpr int kSoon = 12;
  /// One of so many frames in which an object of unknown appearance is lost looks for it by a snapshot, each by
  /// another.
  static constexpr int kSnapshotsEvery = 4;
  /// As frames showed it before, shifted over the whole picture. The album must hold some.
  void relocalize_by_snapshots(const MotionPrior& prior, Alignment& best);
  void relocalize_by_outline(Alignment& best);
  /// Of the poses that a symmetrical shape may be taken for, the one turned least from where it was held last;
  /// mistakable where that is far.
  void tell_apart(Alignment& found);
  /// Compares a held pose with its mirrored tilt by all modalities, over frames, until one of them is clearly better:
  /// that one is gone on with. Undecided until then.
  void tell_from_mirrored(Alignment& best, double time);
  /// Whether texture tells enough to look for a lost object by it.
  bool searches_by_texture(const TrackingState& state) const;
  /// The outline tells more of the pose than texture.
  bool outline_leads(const TrackingState& state) const;
  /// Whether an object that is lost has been seen in so many frames in a row that it is expected there.
  bool seen_often_enough(const TrackingState& state) const;
  Alignment settled(const Alignment& alignment);
  Alignment from_candidate(const PoseCandidate& candidate, const Relocalizer::Levels& levels);
  AlignmentPlan fine_plan(int coarsest, const TrackingState& state) const;
  /// The plan of two coarse levels, from a start that may be far off.
  AlignmentPlan coarse_plan(int coarsest) const;
  /// Aligns from a level down to the finest, without the motion prior.
  Alignment align_anywhere(const Pose& T_start, int coarsest);

  bool goes_on(const Pose& T_from, const Pose& T_to, double most_turn) const;
  AcceptanceContext context(const Alignment& alignment, const TrackingState& state) const;
  bool held(const Alignment& alignment, const TrackingState& state) const {
    return is_held(alignment, context(alignment, state));
  }
  bool held(const Alignment& alignment) const { return held(alignment, state_); }
  bool as_usual(const Alignment& alignment) const { return alignment.score > kUsualShare; }

  /// Gain of the frame's middle channel, or its only one, over the model's texture.
  double gain(const Alignment& alignment) const;
  FrameResult report(const Alignment& alignment, const TrackingState& state);
  void commit(const Alignment& alignment, double time);
  void miss(const Alignment& alignment, double time, FrameResult& result);
  void learn_usual(const Alignment& alignment, bool first, TrackingState& state) const;
  /// Follows the object as one of unknown appearance where frames do not show the model's texture.
  void leave_texture(const Alignment& alignment);
  void learn_contour(const Alignment& alignment);
  /// Keeps how the frame shows a model that has no appearance of its own; of another, how the first frame does.
  void learn_snapshot(const Alignment& alignment);
  void learn_light(const Alignment& alignment, TrackingState& state);
  void learn_texels(const Alignment& alignment);
  void warm_up();

  Tuning tuning_;
  Device device_;
  std::vector<Level> levels_;
  Extent extent_;
  ImageFilter filter_;
  ViewTemplate view_;
  DeviceImage image_;
  Aligner aligner_;
  Relocalizer relocalizer_;
  OutlineSearch outline_search_;
  std::vector<Pose> symmetries_;
  SnapshotAlbum album_;
  LitPatches lit_patches_;

  TrackingState state_;
  TrackingState tried_;  ///< working memory: a state with another way to average texels
  bool has_appearance_ = true;
  bool faceted_ = false;
  bool started_ = false;
  std::optional<double> last_time_;  ///< of the last frame, where frames carry times
  double frames_ = 0;                ///< counted, where they do not
  MotionPrior prior_;                ///< of the frame at hand
  const UploadFrame* upload_ = nullptr;
  Rect uploaded_;
  Alignment last_;  ///< of the last frame, refine()'s too
  bool last_by_contour_ = false;
};

}  // namespace holdfast
