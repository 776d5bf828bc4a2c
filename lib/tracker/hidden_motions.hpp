#pragma once

#include <vector>

#include "solve/normal_equations.hpp"
#include "texture/texture_modality.hpp"

namespace holdfast {

/// The contour's equations without what it tells of motions that the texture drawn at this pose does not show and the
/// contour hardly does: rims of round things seem to tell of their turn where they are cut into facets and pixels.
NormalEquations without_hidden(NormalEquations contour, const TextureTerms& texture, const Pose& T_drawn);

/// An outline's equations without what it tells of these turns, for the same reason.
NormalEquations without_turns(NormalEquations outline, const std::vector<Twist>& turns);

}  // namespace holdfast
