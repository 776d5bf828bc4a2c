#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "holdfast/mesh.hpp"

/// Objects that the program carries itself: nothing has to be downloaded to try or test it. Both are the same for the
/// same seed, centred on the origin, with x to the right, y up and the front face towards z.
namespace holdfast::simulation {

struct BoxOptions {
  Eigen::Vector3d size = Eigen::Vector3d(0.200, 0.150, 0.080);  ///< metres
  double texels_per_metre = 4000;
  double contrast = 1.0;  ///< of the print: 1 as it is, 0 plain cardboard of one colour
  std::uint64_t seed = 1;
};

/// A printed cardboard box: pictures, text, stripes, bar codes.
Mesh textured_box(const BoxOptions& options = {});

/// A toy cube with a large letter on each face.
Mesh lettered_cube(double edge, std::uint64_t seed = 1);

/// A cuboid of one colour (encoded RGB), without texture.
Mesh plain_box(const Eigen::Vector3d& size, const Eigen::Vector3i& rgb);

}  // namespace holdfast::simulation
