#pragma once

#include <cstdint>

#include "simulation/stage.hpp"

namespace holdfast::simulation {

/// Straight at constant speed, then at once into another direction, `options.turns` times or more. Throws
/// Error(invalid_argument) where there is no time or no room for that.
PoseAt sharp_motion(const Stage& stage, const MotionOptions& options, int frames, std::uint64_t seed);

}  // namespace holdfast::simulation
