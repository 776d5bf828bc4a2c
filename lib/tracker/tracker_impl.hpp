#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "contour/outline_memory.hpp"
#include "contour/outline_stage.hpp"
#include "holdfast/tracker.hpp"
#include "image/device_image.hpp"
#include "image/view_template.hpp"
#include "imaging/lit_patches.hpp"
#include "judge/judgement.hpp"
#include "motion/motion_filter.hpp"
#include "motion/motion_model.hpp"
#include "recovery/keyframes.hpp"
#include "recovery/shift_search.hpp"
#include "solve/carried_spread.hpp"
#include "solve/covariance.hpp"
#include "solve/noise_information.hpp"
#include "solve/solver.hpp"
#include "texture/flow_constraints.hpp"
#include "texture/occlusion.hpp"
#include "texture/photometry.hpp"
#include "tracker/tracker_state.hpp"

namespace holdfast {

/// Poses to start the fine stage from, the most promising first.
class Starts {
 public:
  /// Two a hypothesis.
  static constexpr std::size_t kMost = 2 * std::tuple_size_v<decltype(MotionModel::Hypotheses::poses)>;

  void add(const Estimate& start);
  std::size_t count() const { return count_; }
  const Estimate& operator[](std::size_t i) const { return starts_[i]; }
  const Estimate& best() const { return starts_[0]; }

 private:
  std::array<Estimate, kMost> starts_;
  std::size_t count_ = 0;
};

/// The tracker's parts and its loop: a frame's life in tracker.cpp, which starts compete in it in tracker_starts.cpp,
/// the stages that turn a start into an estimate in tracker_stages.cpp, what is expected of the pose beside what the
/// rows say in tracker_expectation.cpp.
struct Tracker::Impl {
  /// Appearances that a lost object is searched for over the whole picture in one frame.
  static constexpr int kAppearancesAFrame = 32;
  /// Places of those that are tracked from, and that the next frame looks at again.
  static constexpr std::size_t kMostPlaces = 3;
  /// Least side of the object on a level that is still worth comparing there, pixels.
  static constexpr double kLeastSide = 20;
  /// Of Student's t that residuals are taken to follow.
  static constexpr double kFreedom = 4;
  /// Motion between frames, pixels, that shows how long the shutter is open.
  static constexpr double kTellingMotion = 6;
  /// Pixels; no bound on motion.
  static constexpr double kAnyMotion = 1e9;

  /// Throws Error for what cannot be used.
  Impl(const Mesh& mesh, const Camera& camera, const TrackerOptions& options, const Device& device);
  /// Of what the other one has checked.
  Impl(const Mesh& mesh, const Camera& camera, const TrackerOptions& options, const Device& device, Renderer renderer);

  /// Does what a frame does once: the device loads its kernels, the driver its shaders, at their first use.
  void warm_up();

  template <typename Frame>
  FrameResult track(const Frame& frame);
  FrameResult refine(const ImageView& frame, const Pose& T_start);

  template <typename Frame>
  FrameResult follow(const Frame& frame, const MotionModel::Hypotheses& hypotheses, bool search);
  /// What is known of a frame before it comes.
  void prepare_frame();
  /// Where the object may be in it.
  MotionModel::Hypotheses hypotheses() const {
    return motion_.hypotheses(options_.predict_velocity, options_.mode != Mode::paper);
  }
  /// Draws the view that the next frame is compared with first.
  void draw_ahead();
  /// Whether where a frame's gradients fit best is searched for around where the object is expected.
  bool searches() const { return options_.correlation_search && options_.mode != Mode::paper; }
  /// Whether the finest level may be enough.
  bool goes_directly() const;
  /// Frame and view are blurred from now on as was measured.
  void set_blur();
  /// Large objects need no full resolution: sets the finest level by the size that the object last had.
  void choose_finest_level();
  /// Goes straight to the finest level from where the object was expected; false when that may not be enough.
  template <typename Frame>
  bool follow_directly(const Frame& frame, const Pose& T_predicted, Estimate& best);
  Estimate track_once(const Pose& T_predicted);
  Estimate coarse_stage(const Pose& T_start, bool search, int coarsest, int finest);
  /// Not solved where it moves the object's corners by more than `most_motion`, pixels of the frame. What an `outline`
  /// says of the pose counts beside the rows.
  Estimate fine_stage(const Pose& T_start, int coarsest, int lit_level, double most_motion = kAnyMotion,
                      const OutlineEstimate* outline = nullptr);
  /// The levels and the part of the frame that following the object from some hypotheses takes.
  struct Scope {
    int finest = 0;                       ///< level that the pose comes from
    int coarsest = 0, coarse_finest = 0;  ///< levels of the coarse stage
    Rect wanted;                          ///< where the object may be
    Rect region;                          ///< what must be seen of the frame
    /// Whether there is a coarse stage.
    bool coarse() const { return coarsest > finest; }
  };
  Scope scope(const MotionModel::Hypotheses& hypotheses, bool search) const;
  /// By texture, and by the outline where that is faint, or was and has vanished. Returns as follow_faint().
  template <typename Frame>
  bool follow_textured(const Frame& frame, const MotionModel::Hypotheses& hypotheses, const Scope& scope, bool search,
                       Estimate& best, OutlineEstimate& outline);
  /// Coarse to fine from every hypothesis that it takes, challenges, and the search for what is lost.
  template <typename Frame>
  Estimate follow_fully(const Frame& frame, const MotionModel::Hypotheses& hypotheses, const Scope& scope, bool search);
  /// What the coarse stage makes of the hypotheses, and the hypotheses themselves.
  Starts coarse_starts(const MotionModel::Hypotheses& hypotheses, const Scope& scope, bool search);
  /// The fine stage from one start after the other until one leads to what fits as usual; else the best, challenged.
  Estimate best_from(const Starts& starts, const MotionModel::Hypotheses& hypotheses, const Scope& scope, bool search);
  /// While no frame has told how coarse colour is, a result below the usual may be better with the other way to draw
  /// it.
  Estimate recolored(const Estimate& doubtful, const Pose& T_start, const Scope& scope);
  /// A result below the usual is challenged: exposures and, if `turn`, starts turned away from it compete with it.
  Estimate challenged(const Estimate& doubtful, const Scope& scope, bool turn);
  /// Searches the whole picture for a lost object: coarse to fine, the next few appearances of the plan in each frame.
  Estimate found_anywhere(const Rect& region);
  /// Near where it is expected, behind an occluder that hides most of it: from wherever a part of the view is seen.
  Estimate found_in_parts(const Pose& T_expected);
  /// A pose and how well the frame's gradients agree with it on some level, at most 1.
  struct Place {
    Pose T_camera_object = Pose::Identity();
    double score = 0;
  };
  /// Adds the best place of each of the next few appearances in the whole picture.
  void sweep(int level, std::vector<Place>& places);
  /// A place moved by up to `reach` pixels of the level to where it fits best.
  Place looked_at(const Pose& T_camera_object, int level, int reach);
  /// A place turned and brought nearer or farther until it fits best.
  Place turned_to_fit(const Place& place, int level);
  /// The coarse stage, on new views while they fit better.
  Estimate coarsely_settled(const Pose& T_start, int coarsest, int finest);
  /// Tilted the other way, as which a flat object far away looks nearly the same; none where that is no other pose.
  std::optional<Pose> mirrored(const Pose& T_camera_object);
  /// What is found, or what it may have been taken for, whichever fits better.
  Estimate best_of_rivals(const Estimate& found, int closer, int coarsest, int coarse_finest);
  /// Leaves the best different ones.
  void keep_best(std::vector<Place>& places, std::size_t count, int level) const;
  /// Pixels of the frame that the object's bounding sphere was wide when it was last seen.
  double diameter_pixels() const;
  /// How well a view fits where it is drawn, motion left alone.
  struct Fit {
    double score = -1;
    double residual = 0;  ///< root of the mean weighted square
  };
  /// That of the view drawn at a pose as a shutter sees it; instead, blurred as much `across` the motion.
  Fit fit(const Pose& T_camera_object, double exposure, bool light, bool across = false);
  /// Measures how long the shutter is open where motion lets it be seen.
  void measure_exposure(const Estimate& estimate);
  /// Measures, now and then, how the camera shows the texture, in a frame that was held with this pose. Changes nothing
  /// else of what is known.
  void measure_optics(const Pose& T_camera_object);
  /// Which of two ways leaves less over. When that is not clear it `stays` as it is, or else is off.
  void measure_choice(const Pose& T_camera_object, Optics& optics, Choice Optics::*choice, bool stays);
  /// How much the lens blurs.
  void measure_lens(const Pose& T_camera_object, Optics& optics);
  /// Of what is usual: times as much.
  struct Change {
    double score = 1;  ///< of the fine stage
    double share = 1;  ///< of the gradient pixels used
  };
  /// How much frame and view are blurred before they are compared, and what that changes.
  Change measure_blur(const Pose& T_camera_object, Optics& optics);
  /// The best pose next to this one, and all that is told of it, when the view is drawn and compared so.
  Estimate refitted(const Pose& T_camera_object, const Optics& optics);
  /// Mean square that the constraints leave over there; 0: none.
  double left_over(const Pose& T_camera_object, const Optics& optics);
  /// Blurs the frame's finest level, around the object there, as these optics say, unless it is so already.
  void blur_frame(const Pose& T_camera_object, const Optics& optics);
  /// The pose turned so that a point at the object's radius moves by `angle` times the radius about a camera axis.
  Pose turned(const Pose& T_camera_object, const Eigen::Vector3d& axis, double angle) const;
  /// One pass of tests, constraints and sums at D, without moving.
  ConstraintSums sums_at(int level, const Pose& D);
  /// The same; light and scale of residuals are learnt from it.
  ConstraintSums evaluate(int level, const Pose& D);
  /// Enqueues tests and constraints of every `thinning`th row.
  kernel::hf_constraints enqueue_level(int level, const Pose& D, int thinning);
  /// Large objects have more constraints than a pose needs: every how manieth row to look at.
  int thinning(int level) const;
  /// Decides every pixel of the last view again, at its last pose.
  void decide_all_pixels();
  /// Draws the view of the last frame's pose again where something else was tried after it.
  void look_at_last();
  /// Thresholds of a level: where the motion is not known yet, gradients differ by it.
  OcclusionOptions tests_of(int level) const;
  /// Iterates on the view that is drawn; returns the last sums. `most_motion` and `outline` as in fine_stage().
  Estimate iterate(int level, Pose& D, int iterations, double most_motion = kAnyMotion,
                   const OutlineEstimate* outline = nullptr);
  /// The sums with what is expected of the pose added as six more observations, and what an outline says as six others.
  ConstraintSums with_expectation(ConstraintSums sums, const Pose& D, const Seen& motion,
                                  const OutlineEstimate* outline) const;
  /// Notes where the object is expected in the next frame, and how surely.
  void expect();
  /// It was found, with this covariance. Returns where its velocity has taken it: the pose itself where that is sure.
  Pose moved_to(const Pose& T_camera_object, const Matrix6& covariance, const Conditioning& condition);
  /// Of the pose expected, conditioned; where none is, of a start.
  Matrix6 expectation_information() const;
  /// What the last sums, of this level, show of the pose: of a motion of which noise alone would say as much, nothing.
  Seen seen_motion(const ConstraintSums& sums, int level) const;
  /// What an observation is off by, squared, in units of the rows' own errors.
  double observation_square(const ConstraintSums& sums) const;
  /// Largest standard deviation that the rows leave of a pose that strays as objects do: object radii and radians.
  double left_open(const ConstraintSums& sums) const;
  /// What the outline's information weighs beside the rows.
  Matrix6 outline_weight(const ConstraintSums& sums, const OutlineEstimate& outline, const Seen& motion) const;
  /// What the last sums, on the finest level, say of the estimate's covariance and of the object's proportions.
  void measure_spread(Estimate& estimate, const OutlineEstimate* outline = nullptr);
  /// How it is drawn now; with `across`, blurred as much at right angles to the motion.
  ViewRequest view_request(const Pose& T_camera_object, int finest, int count, bool across = false) const;
  bool draw(const Pose& T_camera_object, int finest, int count, bool across = false) {
    return draw(view_request(T_camera_object, finest, count, across));
  }
  /// Draws a view, unless it is what was drawn ahead.
  bool draw(const ViewRequest& request);
  /// As if nothing had been drawn yet.
  void forget_view();
  kernel::hf_constraints constraint_options(int level) const;
  Conditioning conditioning() const;
  /// Whether motion goes on as it changes, and its expectation counts: not in the paper's tracker as published.
  bool expects_motion() const { return options_.expected_motion || options_.mode != Mode::paper; }
  /// Pixels of the frame.
  double corner_motion(const Pose& T_a, const Pose& T_b) const;
  /// Whether a pose may be what the other has become in the next frame.
  bool goes_on(const Pose& T_from, const Pose& T_to, double turn) const;
  /// What an estimate must live up to now.
  Standing standing(const Estimate& estimate) const;
  bool is_good(const Estimate& estimate) const { return holdfast::is_good(estimate, options_, standing(estimate)); }
  /// Iterated on new views until the pose stays where it is: a start from far away comes near in few steps only.
  Estimate settled(const Estimate& estimate);
  void remember_score(const Estimate& good);
  /// Where the object is small, learns before its first frame is followed how light falls on it, from the first pose.
  template <typename Frame>
  void light_first_view(const Frame& frame, const Pose& T_camera_object);
  /// Learns from the last view and its samples how light depends on where surface faces.
  void learn_shading();
  /// What the caller is told of an estimate: its verdict and its figures.
  void report(const Estimate& estimate, FrameResult& result) const;

  /// As track(), by the outline alone (tracker_outline.cpp).
  template <typename Frame>
  FrameResult track_outline(const Frame& frame);
  /// As refine(), by the outline alone.
  FrameResult refine_outline(const ImageView& frame, const Pose& T_start);
  template <typename Frame>
  FrameResult follow_outline(const Frame& frame, const MotionModel::Hypotheses& hypotheses);
  /// From one hypothesis after the other until one leads to what fits as usual; else the best.
  OutlineEstimate outline_estimate(const MotionModel::Hypotheses& hypotheses);
  /// A doubtful estimate may have been led astray by what hides the outline: instead another one from there, which goes
  /// on as the object moved, if that fits hardly worse.
  OutlineEstimate steadied(const OutlineEstimate& estimate, const Pose& T_start);
  /// Whether the surface seen from there has enough texture to be followed by; `doubtful` where too little is seen.
  bool shows_texture(const Pose& T_camera_object, bool doubtful = true);
  /// The renderer draws the texture as it is from now on, whatever was measured.
  void draw_plainly();
  /// The same of its other sides, where they surely have.
  bool shows_texture_elsewhere(const Pose& T_camera_object);
  /// Whether it is where the object may be, and looks enough like its outline.
  bool is_followed(const OutlineEstimate& estimate) const;
  /// Whether it is where the object may be.
  bool is_expected(const OutlineEstimate& estimate) const;
  /// By the outline from one hypothesis after the other, and what is learnt from a first pose.
  OutlineEstimate first_outline(const MotionModel::Hypotheses& hypotheses);
  void report_outline(const OutlineEstimate& estimate, FrameResult& result) const;
  /// Counts what the outline has cost.
  void add_outline_effort();

  /// Where texture says too little of the pose: by texture and outline together (tracker_faint.cpp). Whether `outline`
  /// is all there is to go by; otherwise `best` is the answer, by both or, where the outline is lost, by texture:
  /// `searched`, where follow_fully() has been tried already.
  template <typename Frame>
  bool follow_faint(const Frame& frame, const MotionModel::Hypotheses& hypotheses, const Scope& scope, bool search,
                    const Estimate* searched, Estimate& best, OutlineEstimate& outline);
  /// A good estimate by texture with what the outline around it says, if it is there. Whether the view it comes from is
  /// the one `drawn`.
  Estimate beside_outline(const Estimate& alone, bool drawn, OutlineEstimate& outline);
  /// What must be seen of the frame for the outline too.
  Rect outline_region(const Scope& scope) const;
  /// Iterated on, on the view that it comes from, with what the outline says.
  Estimate resumed(const Estimate& estimate, const OutlineEstimate& outline);
  /// How far it is from where its motion leads: object radii and radians.
  double stray(const Pose& T_camera_object) const;
  /// After a frame held.
  void note_stray(const Pose& T_camera_object);
  /// Whether it is farther from where the object's motion leads than that strays.
  bool jumps(const OutlineEstimate& outline) const;
  /// Whether the outline alone is enough to go by for a while.
  bool suffices(const OutlineEstimate& outline) const;
  /// What texture says of the outline where they agree on a pose.
  void compare_outline(const Estimate& both, const OutlineEstimate& outline);
  /// The pose that the outline leads to, turned as was expected where the outline does not show it.
  Pose without_hidden_turns(const OutlineEstimate& outline) const;
  /// The pose that the outline leads to; lost where it does not show how the object is turned.
  void report_outline_of_textured(const OutlineEstimate& outline, FrameResult& result);
  /// After a frame that texture has held: how sure it is, and, where not very, what the outline looks like.
  void judge_texture(const Estimate& estimate);
  /// After a frame that only the outline has.
  void note_outline_of_textured(const FrameResult& result);

  Camera camera_;
  TrackerOptions options_;
  Device device_;
  std::vector<Level> levels_;
  Eigen::Vector3d p_object_center_;
  double radius_;
  ImageFilter filter_;
  ViewTemplate view_;
  DeviceImage image_;
  OcclusionTest occlusion_;
  FlowConstraints constraints_;
  ShiftSearch search_;
  Photometry photometry_;
  OutlineStage outline_;
  MotionModel motion_;
  Restlessness restlessness_;
  MotionFilter motion_filter_;
  LitPatches lit_patches_;
  Keyframes keyframes_;
  Proportions proportions_;
  std::vector<ShiftSearch::Result> parts_;   ///< where they are seen
  std::vector<Place> places_, last_places_;  ///< of the search over the whole picture; the best of the last frame
  bool faceted_ = false;                     ///< flat faces, drawn as light falls on them
  bool textured_ = false;
  bool has_appearance_ = true;       ///< of the mesh, or given since
  bool by_outline_ = false;          ///< nothing but the outline to go by
  bool last_by_outline_ = false;     ///< in the last frame
  Pose T_shown_ = Pose::Identity();  ///< the last frame's, refine()'s too
  bool decided_ = false;             ///< the classes are of the view that is drawn
  OutlineMemory outline_memory_;
  CarriedSpread spread_;
  Look look_;
  Course course_;
  /// On the finest level, as this frame's coarse ones let expect: while no frame was held.
  double first_gradient_pixels_ = 0;
  int looked_at_every_ = 1;                    ///< row of pixels, in the last sums
  kernel::hf_constraints last_constraints_{};  ///< that those were made with
  std::vector<TileEquations> equations_;       ///< of the tiles, in the last estimate
  std::vector<TileEquations> block_strip_;     ///< working memory of score_covariance()
  bool started_ = false;
  Pose T_compared_ = Pose::Identity();  ///< of the view that a frame was compared with last
  Pose D_last_ = Pose::Identity();      ///< of the last sums, from the view that is drawn
  StageTimes times_;
  struct DrawnAhead {
    ViewRequest request;
    int fine_level = -1;  ///< of the blur
    double ms = 0;
  };
  std::optional<DrawnAhead> ahead_;  ///< the view that is drawn, if for a frame that has not come yet
  int solved_systems_ = 0;
  int finest_drawn_ = 0;
  int finest_ = 0;         ///< level that this frame's pose comes from
  bool moved_ = false;     ///< the last pose was the frame before this one's
  bool expected_ = false;  ///< it is known where the object is expected, and how surely, conditioned
  Pose T_expected_ = Pose::Identity();
  Matrix6 expected_information_ = Matrix6::Zero();
  Estimate last_;  ///< of the fine stage, in the last frame

  /// What a frame that is not held must not change.
  struct Appearance {
    Look look;
    Photometry::ObjectPair light;
  };
  Appearance appearance() const { return {look_, photometry_.object_pair()}; }
  void restore(const Appearance& appearance);
};

}  // namespace holdfast
