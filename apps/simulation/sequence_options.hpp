#pragma once

#include "simulation/sequence.hpp"
#include "simulation/simulate_arguments.hpp"

namespace holdfast::simulation {

/// The sequence that the options ask for. Throws Error when they contradict each other or name a file that cannot be
/// read.
SequenceOptions sequence_options(const SimulateArguments& arguments);

}  // namespace holdfast::simulation
