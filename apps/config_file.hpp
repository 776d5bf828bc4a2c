#pragma once

#include <filesystem>

namespace CLI {
class App;
}

namespace holdfast::app {

/// Lets `app` read options from a TOML or INI file: keys are long option names without dashes, and belong to the
/// subcommand that runs, or stand in a section of its name ([track]); sections of other subcommands are skipped,
/// those of none are an error. Call before the subcommands are added.
void enable_config_file(CLI::App& app);

/// Adds --config to a subcommand of such an app.
void add_config_option(CLI::App& subcommand);

/// The file that was given to it; empty: none.
std::filesystem::path config_file(const CLI::App& subcommand);

}  // namespace holdfast::app
