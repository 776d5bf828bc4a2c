#pragma once

#include <optional>

#include "contour/contour_modality.hpp"
#include "edges/edge_modality.hpp"
#include "imaging/imaging_state.hpp"
#include "texture/texture_modality.hpp"

namespace holdfast {

/// A pose that an alignment has led to, with what speaks for it.
struct Alignment {
  Pose T_camera_object = Pose::Identity();
  bool solved = false;
  bool has_texture = false, has_contour = false, has_edges = false;  ///< the modality was asked on the finest level
  TextureTerms texture;
  ContourTerms contour;
  EdgeTerms edges;
  bool has_snapshot = false;
  TextureTerms snapshot;  ///< of the object as a frame showed it
  /// By how much that frame's pose was off, as it seems now: perturbation coordinates.
  Twist snapshot_shift = Twist::Zero();
  double score = -1;        ///< of both, 1 where everything is as usual
  bool undecided = false;   ///< a rival of it fits about as well
  bool mistakable = false;  ///< another pose fits as well, and nothing tells which it is
  /// Of the perturbation (normal_equations.hpp), with everything counted in; zero: not measured.
  Matrix6 covariance = Matrix6::Zero();
  Twist last_step_camera = Twist::Zero();
  std::optional<double> coarse_score;  ///< of texture, where coarse levels led here
  ImagingState imaging;                ///< as learned on the way

  /// Standard deviation of the orientation where it is least sure, radians; infinite where it was not measured.
  double turn_deviation() const;
  /// The same of the motions that texture and contour show on this object.
  double observable_turn_deviation() const;
  /// The largest standard deviation of the place, object radii.
  double place_deviation() const;
  /// The largest standard deviation of all, object radii and radians.
  double deviation() const;
};

/// What is usual of an object's outline in this scene: of its contour and of its edges.
struct UsualOutline {
  double contour_score = 0.85, edge_score = 0.5;
  double edge_share = -1;  ///< of edges in the information of both; below 0: not known yet
  double near = 1;         ///< share of the contour's lines whose edge is next to it
};

/// Share of the contour's lines whose edge is next to it; more than the most is where nothing hides it.
inline constexpr double kMostNear = 0.85;
double near_share(const Alignment& alignment);

/// How well each of them fits, 1 where it does as usual.
double contour_evidence(const Alignment& alignment, const UsualOutline& usual);
double edge_evidence(const Alignment& alignment, const UsualOutline& usual);

/// How well contour and edges fit, 1 where they do as usual: each counts as much as it usually tells of the pose.
double outline_score(const Alignment& alignment, const UsualOutline& usual);

}  // namespace holdfast
