#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/pose.hpp"

namespace holdfast::test {

/// Where a pixel's ray first meets the mesh.
struct RayHit {
  double depth = 0;  ///< Z in the camera frame, metres
  std::size_t triangle = 0;
  Eigen::Vector3d weights;  ///< barycentric, of the triangle's corners
};

/// The obvious renderer in double precision: every ray against every triangle. Knows no OpenGL and nothing of lib/.
class RayCaster {
 public:
  RayCaster(const Mesh& mesh, const Pose& T_camera_object);

  /// The nearest surface seen through `pixel` (any real coordinates, centres at integers), no nearer than `nearest`
  /// metres; both sides of a triangle count.
  std::optional<RayHit> cast(const Camera& camera, const Eigen::Vector2d& pixel, double nearest = 0) const;

  /// RGBA in [0, 255] at full texture resolution, bilinear; `repeat` says what texture coordinates do at the border.
  /// Alpha 0 where the surface has neither texture nor vertex colours.
  Eigen::Vector4d color(const RayHit& hit, bool repeat = false) const;

  /// The same over the pixel's area: four samples of the textured triangle that was hit, a quarter pixel off the centre
  /// each way, averaged as light (squares of what is encoded).
  Eigen::Vector4d pixel_color(const Camera& camera, const Eigen::Vector2d& pixel, const RayHit& hit,
                              bool repeat = false) const;

  /// How many texels of the surface the step to the next pixel (column or row, the longer) passes; 0 without texture.
  double texels_per_pixel(const Camera& camera, const Eigen::Vector2d& pixel, const RayHit& hit) const;

 private:
  std::optional<RayHit> meet_plane(std::size_t triangle, const Eigen::Vector3d& direction) const;
  const Texture* texture_of(std::size_t triangle) const;
  Eigen::Vector2d texture_coordinate(const RayHit& hit) const;

  const Mesh& mesh_;
  std::vector<Eigen::Vector3d> corners_;  ///< three a triangle, camera frame
};

/// A texture's bilinear value in [0, 255]; v upwards, texel centres at half-integers.
Eigen::Vector4d sample_texture(const Texture& texture, const Eigen::Vector2d& coordinate, bool repeat);

}  // namespace holdfast::test
