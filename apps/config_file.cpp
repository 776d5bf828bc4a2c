#include "config_file.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

namespace holdfast::app {
namespace {

constexpr const char* kConfigOption = "--config";

bool has_option(const CLI::App& command, const std::string& name) {
  return command.get_option_no_throw("--" + name) != nullptr || command.get_option_no_throw(name) != nullptr;
}

/// Editors on Windows put one before the first line.
void skip_byte_order_mark(std::istream& input) {
  for (const int byte : {0xef, 0xbb, 0xbf}) {
    if (input.peek() != byte) return;
    input.get();
  }
}

/// CLI11 reads configuration files at the root only, where a subcommand's options need a section. Here options without
/// a section go to the subcommand that runs, so that a file made for `track` need not say [track].
class SubcommandConfig : public CLI::ConfigTOML {
 public:
  explicit SubcommandConfig(const CLI::App& root) : root_(root) {}

  std::vector<CLI::ConfigItem> from_config(std::istream& input) const override {
    const std::vector<CLI::App*> subcommands = root_.get_subcommands();
    const std::vector<const CLI::App*> commands = root_.get_subcommands([](const CLI::App*) { return true; });
    const auto is_command = [&commands](const std::string& name) {
      return std::any_of(commands.begin(), commands.end(),
                         [&name](const CLI::App* command) { return command->get_name() == name; });
    };
    skip_byte_order_mark(input);
    std::vector<CLI::ConfigItem> all = CLI::ConfigTOML::from_config(input);
    if (subcommands.empty()) {
      return {};
    }
    const CLI::App& command = *subcommands.front();
    const std::string selected = command.get_name();
    std::vector<CLI::ConfigItem> kept;
    for (CLI::ConfigItem& item : all) {
      const bool section_mark = item.name == "++" || item.name == "--";
      if (item.parents.empty()) {
        item.parents.push_back(selected);
      } else if (!is_command(item.parents.front())) {
        throw CLI::ConfigError(
            fmt::format("'{}' has a section [{}], but there is no such command: name it [{}], or leave its heading out",
                        config_file(command).string(), item.parents.front(), selected));
      }
      if (!section_mark && item.parents.front() == selected) {
        std::replace(item.name.begin(), item.name.end(), '_', '-');
        if (!has_option(command, item.name)) {
          throw CLI::ConfigError(
              fmt::format("'{}' sets '{}', but '{}' has no option of that name; lines are NAME = VALUE",
                          config_file(command).string(), item.name, selected));
        }
        kept.push_back(std::move(item));
      }
    }
    return kept;
  }

 private:
  const CLI::App& root_;
};

}  // namespace

void enable_config_file(CLI::App& app) {
  app.config_formatter(std::make_shared<SubcommandConfig>(app));
  app.set_config(kConfigOption)->group("");
  app.allow_config_extras(CLI::config_extras_mode::error);
}

void add_config_option(CLI::App& subcommand) {
  CLI::App* root = subcommand.get_parent();
  subcommand
      .add_option_function<std::string>(
          kConfigOption, [root](const std::string& path) { root->get_option(kConfigOption)->add_result(path); },
          "TOML or INI file with options of this command: long names without dashes; the command line wins")
      ->check(CLI::Validator(CLI::ExistingFile).description(""))
      ->type_name("FILE")
      ->trigger_on_parse()
      ->configurable(false);
}

std::filesystem::path config_file(const CLI::App& subcommand) {
  const CLI::Option* option = subcommand.get_parent()->get_option(kConfigOption);
  return option->count() > 0 ? option->as<std::string>() : std::string();
}

}  // namespace holdfast::app
