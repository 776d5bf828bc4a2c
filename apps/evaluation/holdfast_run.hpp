#pragma once

#include "evaluation/protocol.hpp"
#include "evaluation/sequence.hpp"
#include "holdfast/tracker.hpp"

namespace holdfast::evaluation {

/// Holdfast's tracker fed with a sequence's images, one a call, loaded when asked for. `ms.total` of the answers is
/// wall time around Tracker::track. Where the sequence has occluder masks, records say how many of the pixels used lie
/// on occluders. Both arguments must outlive the result. Asking for an image that cannot be read throws Error(file).
TrackerUnderTest under_test(Tracker& tracker, const Sequence& sequence);

}  // namespace holdfast::evaluation
