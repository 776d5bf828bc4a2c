#include "support/run_program.hpp"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>

namespace holdfast::test {
namespace {

[[noreturn]] void become(const std::filesystem::path& program, const Arguments& arguments,
                         const std::filesystem::path& folder, const Environment& environment,
                         const std::filesystem::path& out, const std::filesystem::path& err) {
  constexpr int not_started = 127;
  for (const auto& [name, value] : environment) {
    value.empty() ? unsetenv(name.c_str()) : setenv(name.c_str(), value.c_str(), 1);
  }
  dup2(open("/dev/null", O_RDONLY), STDIN_FILENO);
  dup2(open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), STDOUT_FILENO);
  dup2(open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), STDERR_FILENO);
  std::vector<char*> words{const_cast<char*>(program.c_str())};
  for (const std::string& argument : arguments) {
    words.push_back(const_cast<char*>(argument.c_str()));
  }
  words.push_back(nullptr);
  if (chdir(folder.c_str()) == 0) {
    execv(program.c_str(), words.data());
  }
  _exit(not_started);
}

}  // namespace

ProgramRun run_program(const std::filesystem::path& program, const Arguments& arguments,
                       const std::filesystem::path& folder, const Environment& environment) {
  const TemporaryFolder streams;
  const pid_t child = fork();
  if (child == 0) {
    become(program, arguments, folder, environment, streams / "out", streams / "err");
  }
  int status = 0;
  if (child < 0 || waitpid(child, &status, 0) != child) {
    throw std::runtime_error("cannot run " + program.string());
  }
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), read_file(streams / "out"),
          read_file(streams / "err")};
}

ProgramRun run_holdfast(const Arguments& arguments, const TemporaryFolder& folder, const Environment& environment) {
  return run_program(HOLDFAST_PROGRAM, arguments, folder.path(), environment);
}

std::string program_path() { return HOLDFAST_PROGRAM; }

void check_error(const ProgramRun& run, int exit_code, const std::vector<std::string>& words) {
  CAPTURE(run.err);
  CHECK(run.exit_code == exit_code);
  CHECK(run.err.starts_with("holdfast: error: "));
  CHECK(std::count(run.err.begin(), run.err.end(), '\n') == 1);
  CHECK(run.err.ends_with("\n"));
  CHECK(run.err.find("unexpected") == std::string::npos);
  for (const std::string& word : words) {
    CAPTURE(word);
    CHECK(run.err.find(word) != std::string::npos);
  }
}

}  // namespace holdfast::test
