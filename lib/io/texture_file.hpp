#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

#include "holdfast/mesh.hpp"

namespace holdfast::io {

/// RGBA bytes of a decoded image of 1 to 4 channels (grey, grey and alpha, BGR, BGRA) with 8 or 16 bits. `name` is for
/// the message of Error(file).
Texture texture_from_image(const cv::Mat& image, const std::string& name);

/// An encoded image in memory (PNG, JPEG, ...) as RGBA; throws Error(file).
Texture decode_texture(const void* bytes, std::size_t size, const std::string& name);

/// Writes PNG; throws Error(output).
void save_texture(const std::filesystem::path& path, const Texture& texture);

}  // namespace holdfast::io
