#pragma once

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>

namespace holdfast::io {

/// Levels of lists and objects within each other, beyond which a text is no document but an attack on the stack.
inline constexpr int kMostNested = 64;

/// Parses JSON. Throws std::runtime_error with the reason.
inline nlohmann::json parse_json_text(std::string_view text) {
  const auto not_too_deep = [](int depth, nlohmann::json::parse_event_t, nlohmann::json&) {
    if (depth > kMostNested) throw std::runtime_error("its lists and objects are nested too deeply");
    return true;
  };
  try {
    return nlohmann::json::parse(text, not_too_deep);
  } catch (const nlohmann::json::parse_error& error) {
    throw std::runtime_error("no valid JSON at byte " + std::to_string(error.byte));
  } catch (const nlohmann::json::exception&) {  // a number out of range
    throw std::runtime_error("a number in it is out of range");
  }
}

}  // namespace holdfast::io
