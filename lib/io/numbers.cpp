#include "io/numbers.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <string_view>

namespace holdfast::io {
namespace {

constexpr std::string_view kSeparators = " \t\r\v\f,;[](){}";
constexpr std::string_view kBlanks = " \t\r\v\f";

}  // namespace

std::optional<double> parse_number(std::string_view word) {
  if (word.starts_with('+')) {
    word.remove_prefix(1);
  }
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size()) {
    return std::nullopt;
  }
  return value;
}

bool next_line(std::string_view& text, std::string_view& line) {
  if (text.empty()) {
    return false;
  }
  const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
  line = text.substr(0, end);
  const bool both = text.substr(end).starts_with("\r\n");
  text.remove_prefix(std::min(end + (both ? 2 : 1), text.size()));
  return true;
}

std::string_view next_word(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
  line.remove_prefix(word.size());
  return word;
}

std::string_view trimmed(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  return text.substr(0, text.find_last_not_of(kBlanks) + 1);
}

std::string_view without_comment(std::string_view text) {
  const std::size_t mark = std::min(text.find(" #"), text.find("\t#"));
  return trimmed(text.substr(0, mark));
}

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return result;
}

std::optional<std::vector<NumberLine>> parse_numbers(const std::string& text, int* bad_line, std::string* bad_word) {
  std::vector<NumberLine> lines;
  int line_number = 0;
  for (std::size_t start = 0; start < text.size();) {
    const std::size_t end = std::min(text.find('\n', start), text.size());
    std::string_view line = std::string_view(text).substr(start, end - start);
    start = end + 1;
    NumberLine numbers{++line_number, {}};
    line = line.substr(0, line.find('#'));
    while (true) {
      const std::size_t first = line.find_first_not_of(kSeparators);
      if (first == std::string_view::npos) {
        break;
      }
      line.remove_prefix(first);
      const std::string_view word = line.substr(0, line.find_first_of(kSeparators));
      line.remove_prefix(word.size());
      const std::optional<double> value = parse_number(word);
      if (!value) {
        if (bad_line != nullptr) {
          *bad_line = line_number;
        }
        if (bad_word != nullptr) {
          *bad_word = std::string(word.substr(0, 40));
        }
        return std::nullopt;
      }
      numbers.values.push_back(*value);
    }
    if (!numbers.values.empty()) {
      lines.push_back(std::move(numbers));
    }
  }
  return lines;
}

}  // namespace holdfast::io
