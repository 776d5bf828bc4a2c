#pragma once

#include <vector>

#include "solve/normal_equations.hpp"
#include "texture/texture_modality.hpp"

namespace holdfast {

/// An outline's equations without what they tell of these turns of a round shape, where the texture drawn at this pose
/// does not show them: rims seem to tell of them where they are cut into facets and pixels.
NormalEquations without_hidden(NormalEquations outline, const TextureTerms& texture, const Pose& T_drawn,
                               const std::vector<Twist>& turns);

/// The same whatever a texture shows.
NormalEquations without_turns(NormalEquations outline, const std::vector<Twist>& turns);

}  // namespace holdfast
