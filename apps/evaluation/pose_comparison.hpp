#pragma once

#include <vector>

#include "evaluation/estimated_poses.hpp"
#include "evaluation/protocol.hpp"
#include "evaluation/sequence.hpp"

namespace holdfast::evaluation {

/// Poses that were estimated earlier against a sequence's truth: one record a frame, counted and failed as in
/// run_protocol(). Throws Error(file), naming both counts, when the estimates are not one for every frame of the
/// sequence; `partial` accepts any part of it.
std::vector<FrameRecord> compare_poses(const Sequence& sequence, const EstimatedPoses& estimates,
                                       const Tolerance& failure, double minimum_visible, bool partial);

}  // namespace holdfast::evaluation
