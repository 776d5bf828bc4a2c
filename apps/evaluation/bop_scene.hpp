#pragma once

#include <optional>

#include "evaluation/sequence.hpp"

namespace holdfast::evaluation {

/// Fills a sequence from the BOP scene in its folder (load_sequence): all but the camera's size. The table of true
/// poses comes first in `tables`. Throws Error(file) or Error(pose).
void load_bop_scene(Sequence& sequence, std::optional<int> object);

}  // namespace holdfast::evaluation
