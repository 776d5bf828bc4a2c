#pragma once

#include <optional>

#include "base/corner_motion.hpp"
#include "image/view_template.hpp"

namespace holdfast {

/// Poses turned by less than this from each other, radians, are no rivals: 5 degrees.
inline constexpr double kSamePose = 0.087;

/// The pose whose visible surface is tilted the other way: seen from far, what is nearly flat looks much the same
/// there. `view` must have drawn the object near this pose. None where it hardly differs, or where nothing is seen.
std::optional<Pose> mirrored_tilt(const ViewTemplate& view, const Pose& T_camera_object, const Extent& extent);

}  // namespace holdfast
