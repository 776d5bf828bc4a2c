#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <vector>

#include "detection/robust_pnp.hpp"

namespace holdfast::detection {

/// A focal length fitted to frames together with all that is not known beside it: the poses, the principal point, lens
/// distortion, and how the model differs from the object, as a stretch of the whole and as shifts of its parts. Each of
/// these has a usual deviation; how far they can take the focal length along is part of its variance.
class FocalFit {
 public:
  /// `center`, `width`: of the picture, pixels; `radius`: of the model, metres.
  FocalFit(double focal, const Eigen::Vector2d& center, double width, double radius);

  /// Fits to frames; their poses are where it begins, and are moved along.
  void fit(std::vector<Consensus>& frames);

  double focal() const { return focal_; }
  /// Of the focal length's logarithm.
  double variance() const { return variance_; }

 private:
  /// What all frames have in common: logarithm of the focal length, principal point (in widths), k1, and the six
  /// entries of a symmetric stretch of the model.
  static constexpr int kShared = 10;
  using Shared = Eigen::Matrix<double, kShared, 1>;
  /// A part of the model: a cube of space.
  using Part = std::array<int, 3>;

  struct Sums;
  Sums sums(const std::vector<Consensus>& frames) const;
  /// Cost in units of the noise's variance, priors included.
  double cost(const Sums& sums, double noise) const;

  double focal_;
  Eigen::Vector2d center_;
  double width_, radius_;
  Shared offsets_ = Shared::Zero();         ///< of all but the focal length, whose entry stays 0
  std::map<Part, Eigen::Vector3d> shifts_;  ///< of parts, in radii; none: 0
  double variance_ = 0;
};

}  // namespace holdfast::detection
