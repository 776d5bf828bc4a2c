#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace holdfast::app {

struct ListedImage {
  std::filesystem::path path;
  std::int64_t index = 0;  ///< frame number
};

/// The images that an input names, in the order of their frames; nothing when the input is neither of
/// - a folder: its image files in natural order (2 before 10), numbered from 0;
/// - a glob pattern (frames/*.png): likewise;
/// - a printf pattern (frames/%06d.png): numbered as the file names say;
/// - one image file.
/// An existing file is never taken for a pattern. Throws Error(file) when there are no such images.
std::optional<std::vector<ListedImage>> list_images(const std::string& input);

/// A warning where images of two extensions are among these, or as many of one name as of another, but for their
/// numbers: copies and masks of frames would be tracked as frames.
std::optional<std::string> other_images(const std::vector<ListedImage>& images);

/// Whether a file of this name is taken for an image in a folder.
bool is_image_name(const std::filesystem::path& path);

/// True when `a` comes before `b` with runs of digits compared as numbers.
bool natural_less(const std::string& a, const std::string& b);

}  // namespace holdfast::app
