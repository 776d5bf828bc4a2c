#pragma once

#include <string>

#include "base/tuning.hpp"
#include "holdfast/frame_result.hpp"
#include "judge/alignment.hpp"

namespace holdfast {

/// What acceptance of an alignment hangs on beside its evidence: what is usual, and where it was expected.
struct AcceptanceContext {
  bool first = false;        ///< no frame has shown it yet
  bool lost_before = false;  ///< to be found again takes more than to be held on to
  bool surprising = false;   ///< far from where its motion leads: takes more, too
  bool near = false;         ///< near where it was or is expected
  bool expected = false;     ///< so, or seen there by the frames before
  bool searched_everywhere = false;
  bool jumps = false;             ///< farther from where its motion leads than it usually strays
  double least_ratio = 0.1;       ///< of texture that must agree; fewer pass the paper's thresholds
  double usual_inlier_ratio = 0;  ///< of texture; 0: unknown
  UsualOutline usual_outline;
  double texture_trust = 1;           ///< share of texture in what is usually known of the pose
  bool unobservable_usually = false;  ///< some motion never shows: that it does not speaks against nothing
  bool print_missing = false;         ///< the model has a print that is not there where its outline is
  bool sure_snapshot = false;         ///< the snapshot is of the object, not of what hid it
  int without_outline = 0;            ///< frames in a row in which a snapshot held it and the outline did not show it
  double predicted_pixels = 0;        ///< farthest that the object was expected to move since the last frame
  double blur_pixels = 0;             ///< motion blur
  double gain = 1;                    ///< of the frame over the model's texture, over what it was
};

/// Share of texture in what is usually known, above which texture leads: the contour alone needs more to hold the
/// object.
inline constexpr double kTextureLeads = 0.5;

struct Verdict {
  Status status = Status::lost;
  Reason reason = Reason::none;
  std::string message;
};

/// Whether an alignment is the object, and why not. A held object has a reason too where it is hard to hold.
Verdict judge(const Alignment& alignment, const Tuning& tuning, const AcceptanceContext& context);

/// As judge(), without words.
bool is_held(const Alignment& alignment, const AcceptanceContext& context);
/// Whether texture alone holds it.
bool is_held_by_texture(const Alignment& alignment, const AcceptanceContext& context);
/// Whether the contour is there, where the object may be.
bool is_held_by_contour(const Alignment& alignment, const AcceptanceContext& context);

/// The object's pixels are those of the snapshot, as far as they show it.
bool is_as_in_snapshot(const Alignment& alignment);

/// Whether its pixels are those that a frame showed of it.
bool is_held_by_snapshot(const Alignment& alignment, const AcceptanceContext& context);
/// Whether next to nothing hides its outline, so that a snapshot taken there is of the object.
bool shows_all(const Alignment& alignment, const UsualOutline& usual);

/// Found again after a loss, if the next frames agree.
bool is_probable(const Alignment& alignment, const AcceptanceContext& context);

/// The outline is there, though not clearly: what frames before have shown of it counts on.
bool may_go_on(const Alignment& alignment, const AcceptanceContext& context);

/// Not to be believed, but worth starting from in the next frame.
bool is_promising(const Alignment& alignment, const AcceptanceContext& context);

}  // namespace holdfast
