#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace holdfast::io {

/// A calibration file of any syntax as one tree: XML (OpenCV's), JSON, or YAML (with or without OpenCV's header and
/// tags). Matrices stay what the file makes of them: {rows, cols, data} or nested lists. Throws Error(camera) when the
/// text is none of these.
nlohmann::json parse_calibration(const std::string& text, const std::filesystem::path& path);

}  // namespace holdfast::io
