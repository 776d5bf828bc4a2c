#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "device/shared.h"
#include "image/depth_view.hpp"

namespace holdfast {

/// Part of an object's contour as it is seen from a pose.
struct ContourPoint {
  Eigen::Vector3f p_camera = Eigen::Vector3f::Zero();  ///< metres
  Eigen::Vector2f normal = Eigen::Vector2f::Zero();    ///< out of the object, unit length
  float inside = 0;                                    ///< how far the object reaches along it, pixels
  float outside = 0;                                   ///< how far the background does
  float unused = 0;
};
static_assert(sizeof(ContourPoint) == HF_CONTOUR_POINT * sizeof(float));

/// Working memory of contour_points().
struct ContourScan {
  struct Pixel {
    int x, y;
  };
  std::vector<Pixel> pixels;
  std::vector<std::uint8_t> marks;
};

/// At most `most` points, evenly along the contour where it lies inside the picture; the object must be seen for some
/// pixels inside of each. `reach`: pixels that the lines are looked at on either side (equation 23 of docs/math.md).
void contour_points(const DrawnDepth& drawn, const Camera& camera, std::size_t most, int reach, ContourScan& scan,
                    std::vector<ContourPoint>& points);

}  // namespace holdfast
