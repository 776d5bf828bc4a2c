#pragma once

#include <cstdint>
#include <vector>

namespace holdfast {

/// How well each place of a small picture agrees with an edge or a contour of each direction, a byte each: what
/// templates of points with directions are compared with (equation 38 of docs/math.md).
class DirectionResponses {
 public:
  /// Directions of edges, over half a turn, and of contours, whose side matters, over a whole one.
  static constexpr int kEdges = 8, kContours = 16;
  /// Pixels between the places that a template is tried at.
  static constexpr int kStep = 2;
  /// Response where nothing tells; 255 where all agrees.
  static constexpr int kNothing = 64;

  /// The direction of a normal, 0 to kContours - 1; that of the edge is its remainder by kEdges.
  static int direction(double x, double y);

  /// `rgb`: four floats a pixel, 0 to 1, of which three are looked at; `says`: what each pixel's colour says for the
  /// object, -1 to 1. `stride`: pixels from row to row of `rgb`. Beyond the picture, `margin` pixels around it, nothing
  /// tells.
  void compute(const float* rgb, int stride, const std::vector<float>& says, int width, int height, int margin);

  int columns() const { return columns_; }  ///< places in a row, margins included
  int rows() const { return rows_; }
  int margin() const { return margin_; }
  /// Responses at (x + kStep * i, y + kStep * j), at plane[j * columns() + i]: x and y count from the margin's corner.
  const std::uint8_t* edges(int direction, int x, int y) const { return planes_.data() + at(direction, x, y); }
  const std::uint8_t* contours(int direction, int x, int y) const { return edges(kEdges + direction, x, y); }

 private:
  void find_edges(const float* rgb, int stride);
  std::vector<float> beside_others(const float* value) const;
  /// Index of a response in planes_.
  std::size_t at(int plane, int x, int y) const {
    const int phase = (y % kStep) * kStep + x % kStep;
    return (std::size_t{1} * (plane * kStep * kStep + phase) * rows_ + y / kStep) * columns_ + x / kStep;
  }
  /// Index of a pixel.
  std::size_t index(int x, int y) const { return std::size_t{1} * y * width_ + x; }

  int width_ = 0, height_ = 0, margin_ = 0, columns_ = 0, rows_ = 0;
  std::vector<float> strength_;
  std::vector<std::uint8_t> seen_;  ///< edges near a pixel: a bit a direction
  std::vector<std::uint8_t> own_;   ///< edges on a pixel
  std::vector<std::uint8_t> planes_;
};

}  // namespace holdfast
