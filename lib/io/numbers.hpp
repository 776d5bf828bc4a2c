#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace holdfast::io {

/// The number that a word is, whatever the locale: "1", "-.5", "+2.", "1e-3", "nan"; nothing for another word.
std::optional<double> parse_number(std::string_view word);

/// Takes the next line off a text, without its end ("\n", "\r\n" or "\r"); false where no text is left.
bool next_line(std::string_view& text, std::string_view& line);

/// Takes the next word off a line; empty where there is none.
std::string_view next_word(std::string_view& line);

/// A text without blanks around it.
std::string_view trimmed(std::string_view text);

/// A text without a comment that stands at its end, after a blank and '#'; names may have a '#' within.
std::string_view without_comment(std::string_view text);

/// A text with the letters of ASCII in lower case.
std::string lower(std::string_view text);

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
