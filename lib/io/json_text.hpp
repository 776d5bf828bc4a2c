#pragma once

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>

namespace holdfast::io {

/// Levels of lists and objects within each other, beyond which a text is no document but an attack on the stack.
inline constexpr int kMostNested = 64;

/// True where lists and objects of a JSON text are nested more deeply than that.
inline bool is_nested_too_deeply(std::string_view text) {
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size() && depth <= kMostNested; ++i) {
    const char c = text[i];
    if (c == '"') {
      in_string = !in_string;
    } else if (in_string) {
      i += c == '\\' ? 1 : 0;
    } else if (c == '[' || c == '{') {
      ++depth;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return depth > kMostNested;
}

/// Parses JSON. Throws std::runtime_error with the reason. Not by the library's callback for each level: with one it
/// goes through all of a list at the end of each object in it.
inline nlohmann::json parse_json_text(std::string_view text) {
  if (is_nested_too_deeply(text)) throw std::runtime_error("its lists and objects are nested too deeply");
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::parse_error& error) {
    throw std::runtime_error("no valid JSON at byte " + std::to_string(error.byte));
  } catch (const nlohmann::json::exception&) {  // a number out of range
    throw std::runtime_error("a number in it is out of range");
  }
}

}  // namespace holdfast::io
