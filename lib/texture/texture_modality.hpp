#pragma once

#include <array>
#include <vector>

#include "base/tuning.hpp"
#include "image/device_image.hpp"
#include "image/view_template.hpp"
#include "solve/normal_equations.hpp"
#include "texture/flow_constraints.hpp"
#include "texture/noise_information.hpp"
#include "texture/photometry.hpp"
#include "texture/score_covariance.hpp"

namespace holdfast {

/// What is learned of how the frame shows the texture.
struct TextureState {
  static constexpr std::size_t kMostLevels = 6;
  std::array<double, kMostLevels> residual_scale{0.05, 0.05, 0.05, 0.05, 0.05, 0.05};  ///< a level each
  Photometry::ObjectPair light;
};

/// What the texture says of a pose.
struct TextureTerms {
  ConstraintSums sums;
  double correlation = 0;  ///< of rendered view and frame over the used pixels, each cell about its own means
  int row_stride = 1;      ///< of the pixels that were looked at
  double reliability = 0;  ///< share of its information that is believed (equation 14a of docs/math.md)
  NormalEquations equations;
  UnobservableMotions unobservable;  ///< where asked for

  double inlier_ratio() const { return sums.used / std::max(1.0, sums.gradient); }
  /// At most 1. Pixels that left the sampled region speak against it too.
  double score() const {
    return inlier_ratio() * sums.usable / std::max(1.0, sums.visible) * std::max(0.0, correlation);
  }
};

/// How a level is linearized.
struct TextureRequest {
  int level = 0;
  int finest = 0;             ///< level that the pose comes from: coarser ones have looser tests
  int row_stride = 1;         ///< of the pixels to look at
  bool learn = true;          ///< light and residual scale from these sums
  bool unobservable = false;  ///< motions that noise alone would show as well are removed
};

/// The texture as a modality: rejects pixels whose gradients break brightness constancy, turns the others into flow
/// constraints and sums them up (equations 7 to 17 of docs/math.md). Keeps no pose; gain and bias of cells are working
/// memory of the view at hand.
class TextureModality {
 public:
  TextureModality(const Device::Impl& device, const std::vector<Level>& levels, const Extent& extent,
                  const Tuning& tuning);

  /// No level has gain and bias of its own any more; the object's are these.
  void start(const TextureState& state);
  /// Gain and bias of a level's cells: the object's, or those of the coarser level `from_level`.
  void start_level(const ViewTemplate& view, int level, int from_level = -1) {
    photometry_.start_level(level, view.planes(level).tiles, from_level);
  }

  /// Tests, constraints and normal equations when the view has moved by D since it was drawn. Waits for the device.
  TextureTerms linearize(const ViewTemplate& view, const DeviceImage& image, const Pose& D,
                         const TextureRequest& request, TextureState& state) {
    enqueue(view, image, D, request, state);
    return read(view, state);
  }
  /// Both halves of linearize(): the device works between them.
  void enqueue(const ViewTemplate& view, const DeviceImage& image, const Pose& D, const TextureRequest& request,
               const TextureState& state);
  TextureTerms read(const ViewTemplate& view, TextureState& state);

  /// Removes from the terms linearized last the motions that noise alone would show as well: what is left of the
  /// equations has nothing to do with them.
  void remove_unobservable(const ViewTemplate& view, int level, TextureTerms& terms);

  /// Covariance of the pose, perturbation coordinates, after a last step (camera axes) from these terms; `others`: what
  /// motion and other modalities know. From how blocks of tiles disagree (equation 12).
  Matrix6 covariance(const ViewTemplate& view, const TextureTerms& terms, const Twist& last_step_camera,
                     const Matrix6& others);

  /// Samples and classes of what was linearized last.
  const FlowConstraints& constraints() const { return constraints_; }
  Photometry& photometry() { return photometry_; }

 private:
  double rows_per_observation() const;
  void set_equations(const ViewTemplate& view, TextureTerms& terms) const;
  kernel::hf_constraints constraint_options(const TextureRequest& request, const Conditioning& conditioning,
                                            const TextureState& state) const;
  OcclusionOptions tests_of(const TextureRequest& request) const;
  Conditioning conditioning(const ViewTemplate& view) const {
    return {view.T_camera_object() * extent_.p_object_center, extent_.radius};
  }

  const std::vector<Level>& levels_;
  Extent extent_;
  Tuning tuning_;
  FlowConstraints constraints_;
  Photometry photometry_;
  TextureRequest request_;  ///< of what was enqueued last
  kernel::hf_constraints last_{};
  bool grey_ = false;
  std::vector<TileEquations> tiles_, block_strip_;
};

/// Share of the texture's information that is believed when this share of its gradient pixels passed the tests and
/// rendered view and frame correlate so over them: pixels pass by chance, too.
double texture_reliability(double inlier_ratio, double correlation);

}  // namespace holdfast
