#pragma once

#include <optional>
#include <string>
#include <vector>

namespace holdfast::io {

/// Numbers of one line of a text file.
struct NumberLine {
  int line = 0;  ///< counted from 1
  std::vector<double> values;
};

/// The numbers of a text file, line by line, lines without any left out. Blanks, commas, semicolons and brackets
/// separate, '#' starts a comment, '.' is the decimal point whatever the locale. Nothing when there are other words;
/// then `bad_line` and `bad_word`, where given, say the first.
std::optional<std::vector<NumberLine>> parse_numbers(const std::string& text, int* bad_line = nullptr,
                                                     std::string* bad_word = nullptr);

}  // namespace holdfast::io
