#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <iostream>
#include <memory>
#include <new>
#include <opencv2/core/utils/logger.hpp>
#include <regex>
#include <string>
#include <string_view>
#include <vector>

#include "commands.hpp"
#include "config_file.hpp"
#include "exit_codes.hpp"
#include "messages.hpp"
#include "nearest_name.hpp"

namespace {

constexpr const char* kExitCodes =
    "Exit codes: 0 done, 2 wrong option, 3 an input (model, video, camera, pose) is missing or unusable, 4 no OpenCL\n"
    "device or renderer, 5 an output cannot be written, 6 held in no frame, lost with 'track --require-held',\n"
    "or too far off with 'evaluate --within', 130 interrupted by Ctrl-C, 1 anything unexpected.";

/// Flags with a negative form as one writes them: CLI11 adds "{false}".
class PlainFormatter : public CLI::Formatter {
 public:
  std::string make_option_name(const CLI::Option* option, bool is_positional) const override {
    constexpr std::string_view mark = "{false}";
    std::string name = CLI::Formatter::make_option_name(option, is_positional);
    if (const std::size_t found = name.find(mark); found != name.npos) {
      name.erase(found, mark.size());
    }
    return name;
  }
};

/// A standard stream that the caller has closed would be the number of the first file that is opened: what is printed
/// would go into it.
void open_standard_streams() {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream) {
    if (fcntl(stream, F_GETFD) == -1 && errno == EBADF) {
      (void)open("/dev/null", stream == STDIN_FILENO ? O_RDONLY : O_WRONLY);  // the lowest number that is free
    }
  }
}

/// The exit code after all that was printed has been written.
int after_printing(int exit_code) {
  errno = 0;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return exit_code;
  holdfast::app::print_error(std::string("cannot write to the standard output: ") +
                             (errno != 0 ? std::strerror(errno) : "is it full?"));
  return exit_code == holdfast::app::kOk ? holdfast::app::kOutput : exit_code;
}

/// The program's messages are one line each: OpenCV and FFmpeg stay silent unless the user asks for their logs.
void silence_libraries() {
  constexpr int keep = 0;
  if (std::getenv("OPENCV_LOG_LEVEL") == nullptr) {  // OpenCV has read it before main()
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    std::cerr.rdbuf(nullptr);  // OpenCV's image decoders write to it past its log; the program itself writes to stderr
  }
  setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", keep);
}

std::string did_you_mean(const std::string& given, const std::vector<std::string>& names) {
  const std::string nearest = holdfast::app::nearest_name(given, names);
  return nearest.empty() ? "" : "; did you mean '" + nearest + "'?";
}

/// A value that is missing, or is no number, in the words that one would use.
std::string plain_words(const std::string& words) {
  std::smatch parts;
  if (std::regex_match(words, parts, std::regex("Could not convert: (\\S+) = (.*)"))) {
    const std::string value = parts[2];
    char* end = nullptr;
    std::strtoll(value.c_str(), &end, 10);
    if (!value.empty() && *end == '\0') return fmt::format("{}: {} is out of range", parts[1].str(), value);
    std::strtod(value.c_str(), &end);
    const bool number = !value.empty() && *end == '\0';
    return fmt::format("{} takes a {}number, not '{}'", parts[1].str(), number ? "whole " : "", value);
  }
  if (std::regex_match(words, parts, std::regex("(\\S+): (\\d+) required (.+) missing"))) {
    return fmt::format("{} needs {}: {}", parts[1].str(), parts[2] == "1" ? "a value" : parts[2].str() + " values",
                       parts[3].str());
  }
  return words;
}

/// An option that does not exist comes first, with the one that was meant: what CLI11 misses may be just that.
std::string message_of(const CLI::App& command, const CLI::ParseError& error) {
  const std::vector<std::string> remaining = command.remaining();
  const auto unknown = std::find_if(remaining.begin(), remaining.end(),
                                    [](const std::string& argument) { return argument.starts_with("-"); });
  const int code = error.get_exit_code();
  const bool follows =
      code == static_cast<int>(CLI::ExitCodes::ExtrasError) || code == static_cast<int>(CLI::ExitCodes::RequiredError);
  if (!follows || unknown == remaining.end()) {
    if (code != static_cast<int>(CLI::ExitCodes::ExtrasError) || remaining.empty()) return plain_words(error.what());
    return fmt::format(
        "'{}' is one argument too many: a pattern of images needs quotes, 'frames/*.png', and a name "
        "with blanks too",
        *std::min_element(remaining.begin(), remaining.end()));
  }
  const std::string name = unknown->substr(0, unknown->find('='));
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& long_name : option->get_lnames()) names.push_back("--" + long_name);
  }
  return "there is no option '" + name + "'" + did_you_mean(name, names);
}

int report(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
    return app.exit(error);  // --help or --version
  }
  const auto subcommands = app.get_subcommands();
  const std::vector<std::string> remaining = app.remaining();
  if (subcommands.empty()) {
    std::vector<std::string> commands;
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
      commands.push_back(command->get_name());
    }
    holdfast::app::print_error((remaining.empty() ? fmt::format("a command is missing: {}", fmt::join(commands, ", "))
                                                  : "there is no command '" + remaining.front() + "'" +
                                                        did_you_mean(remaining.front(), commands)) +
                               " (see 'holdfast --help')");
    return holdfast::app::kUsage;
  }
  const CLI::App& command = *subcommands.front();
  holdfast::app::print_error(message_of(command, error) + " (see 'holdfast " + command.get_name() + " --help')");
  return holdfast::app::kUsage;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace holdfast::app;
  open_standard_streams();
  silence_libraries();
  CLI::App app(
      "Holds on to a moving object: follows the position and orientation of one object of known shape, printed\n"
      "or plain, through a video, while it turns and while things pass in front of it.",
      "holdfast");
  app.set_version_flag("--version", "holdfast " HOLDFAST_VERSION);
  app.require_subcommand(1);
  app.footer(kExitCodes);  // subcommands inherit it
  app.formatter(std::make_shared<PlainFormatter>());
  app.get_formatter()->column_width(38);
  enable_config_file(app);

  int exit_code = kOk;
  holdfast::add_track_command(app, exit_code);
  holdfast::add_init_command(app, exit_code);
  holdfast::add_bake_command(app, exit_code);
  holdfast::add_show_command(app, exit_code);
  holdfast::add_devices_command(app, exit_code);
  holdfast::add_simulate_command(app, exit_code);
  holdfast::add_evaluate_command(app, exit_code);
  app.footer(std::string("'holdfast COMMAND --help' lists a command's options.\n\n") + kExitCodes);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return after_printing(report(app, error));
  } catch (const holdfast::Error& error) {
    print_error(error.what());
    return exit_code_of(error.code());
  } catch (const std::bad_alloc&) {
    print_error("out of memory: use a smaller model or smaller frames");
    return kUnexpected;
  } catch (const std::exception& error) {
    if (std::ferror(stdout) != 0) return after_printing(kOk);  // printing fails by an exception too
    print_error(std::string("unexpected: ") + error.what());
    return kUnexpected;
  }
  return after_printing(exit_code);
}
