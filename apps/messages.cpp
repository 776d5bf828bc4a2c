#include "messages.hpp"

#include <fmt/format.h>

#include <cctype>
#include <cstdio>

namespace holdfast::app {

std::string one_line(const std::string& text) {
  std::string line;
  for (const unsigned char c : text) {
    if (!std::isspace(c)) {
      line += static_cast<char>(c);
    } else if (!line.empty() && line.back() != ' ') {
      line += ' ';
    }
  }
  if (line.ends_with(' ')) {
    line.pop_back();
  }
  return line;
}

void print_note(const std::string& message) { fmt::print(stderr, "holdfast: {}\n", one_line(message)); }

void print_error(const std::string& message) { fmt::print(stderr, "holdfast: error: {}\n", one_line(message)); }

void print_warning(const std::string& message) { fmt::print(stderr, "holdfast: warning: {}\n", one_line(message)); }

void warn_if(const std::optional<std::string>& doubt) {
  if (doubt) print_warning(*doubt);
}

}  // namespace holdfast::app
