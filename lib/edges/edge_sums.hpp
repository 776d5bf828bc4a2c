#pragma once

#include "edges/visible_edges.hpp"
#include "solve/normal_equations.hpp"

namespace holdfast {

/// Sums over the rows of lines across edges, and their normal equations (equations 34 to 36 of docs/math.md).
class EdgeSums {
 public:
  explicit EdgeSums(const Conditioning& conditioning) : conditioning_(conditioning) {}

  /// A line that has moved by D since it was laid and whose edge is found `offset` pixels along its normal, with this
  /// weight. Lines of a chain follow each other.
  void add(const VisibleEdge& edge, const Pose& D, const Camera& camera, int chain, double weight, double offset);

  double rows() const { return rows_; }
  /// Mean square of the offsets, square pixels.
  double variance() const;
  /// In information units, of lines laid at T_lines: what all edges of a chain are off by together is eliminated, and
  /// motions that edges show no better than the errors of their directions do are left out.
  NormalEquations equations(const Pose& T_lines) const;

  /// d(pixels along `direction`) / d(conditioned twist) of the point p_camera when it has moved by D: equation 28.
  static Twist row(const Eigen::Vector3d& p_camera, const Pose& D, const Eigen::Vector2d& direction,
                   const Camera& camera, const Conditioning& conditioning);

 private:
  /// What h gains where all edges of a chain are found a pixel farther along their normals.
  struct Shift {
    Twist coupling = Twist::Zero();
    double weight = 0, offset = 0;
  };

  void eliminate(Matrix6& A, Twist& h) const;

  Conditioning conditioning_;
  Matrix6 A_ = Matrix6::Zero();
  Twist h_ = Twist::Zero();
  Matrix6 astray_ = Matrix6::Zero();  ///< what errors of the directions would make of A
  double weighted_square_ = 0, rows_ = 0;
  int chain_ = -1;  ///< of the last line
  Shift shift_;     ///< of that chain, not yet eliminated
};

}  // namespace holdfast
