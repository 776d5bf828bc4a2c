#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

namespace holdfast::io {

/// The XML that OpenCV writes, as a tree: elements are objects, those named "_" lists, and what stands between tags is
/// a number, a list of numbers or a string. Throws std::runtime_error with the reason, also where it is nested too
/// deeply.
nlohmann::json parse_xml_text(std::string_view text);

}  // namespace holdfast::io
