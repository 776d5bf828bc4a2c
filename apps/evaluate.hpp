#pragma once

#include <CLI/CLI.hpp>

namespace holdfast {

/// `holdfast evaluate`: the tracker, or poses it wrote, against ground truth. `exit_code` is set when the command ran.
void add_evaluate_command(CLI::App& app, int& exit_code);

}  // namespace holdfast
