#pragma once

namespace CLI {
class App;
}

/// The program's subcommands, one a file. Each registers its options on a subcommand of `app` and a callback that runs
/// it, sets `exit_code` (exit_codes.hpp) where that is not 0, and throws holdfast::Error when it cannot.
namespace holdfast {

void add_track_command(CLI::App& app, int& exit_code);
void add_init_command(CLI::App& app, int& exit_code);
void add_bake_command(CLI::App& app, int& exit_code);
void add_show_command(CLI::App& app, int& exit_code);
void add_devices_command(CLI::App& app, int& exit_code);
void add_simulate_command(CLI::App& app, int& exit_code);
void add_evaluate_command(CLI::App& app, int& exit_code);

}  // namespace holdfast
