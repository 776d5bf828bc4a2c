#pragma once

#include "evaluation/pose_error.hpp"
#include "holdfast/pose.hpp"

namespace holdfast::test {

/// What the RBOT benchmark calls a failure.
inline const evaluation::Tolerance kRbotFailure = evaluation::tolerance_mm_deg(50, 5);

/// Shifted in the camera's axes, turned about its own z.
Pose moved(const Pose& pose, double x_mm, double y_mm, double z_mm, double degrees_about_z = 0);

}  // namespace holdfast::test
