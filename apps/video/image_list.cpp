#include "video/image_list.hpp"

#include <fmt/format.h>
#include <glob.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <regex>
#include <string_view>
#include <system_error>

#include "holdfast/error.hpp"

namespace holdfast::app {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 14> kImageExtensions = {
    ".jpg", ".jpeg", ".jpe", ".jp2", ".png", ".bmp", ".tif", ".tiff", ".webp", ".ppm", ".pgm", ".pbm", ".pnm", ".hdr"};

std::vector<fs::path> files_of(const fs::path& folder) {
  std::error_code failed;
  std::vector<fs::path> files;
  for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end; entry.increment(failed)) {
    files.push_back(entry->path());
  }
  if (failed) {
    throw Error(ErrorCode::file, fmt::format("cannot list the folder '{}': {}", folder.string(), failed.message()));
  }
  return files;
}

std::vector<ListedImage> numbered_from_zero(std::vector<fs::path> files) {
  std::sort(files.begin(), files.end(),
            [](const fs::path& a, const fs::path& b) { return natural_less(a.string(), b.string()); });
  std::vector<ListedImage> images;
  images.reserve(files.size());
  for (fs::path& file : files) {
    images.push_back({std::move(file), static_cast<std::int64_t>(images.size())});
  }
  return images;
}

/// The first of these that is a folder and holds images.
std::optional<fs::path> folder_with_images(std::vector<fs::path> paths) {
  std::error_code failed;
  std::erase_if(paths, [&](const fs::path& path) { return !fs::is_directory(path, failed); });
  std::sort(paths.begin(), paths.end());
  for (const fs::path& path : paths) {
    for (fs::directory_iterator entry(path, failed), end; !failed && entry != end; entry.increment(failed)) {
      if (is_image_name(entry->path()) && !entry->path().filename().string().starts_with('.')) {
        return path;
      }
    }
  }
  return std::nullopt;
}

/// What systems leave beside their users' files, such as macOS's "._frame.jpg", which is no picture.
bool is_hidden(const fs::path& file) { return file.filename().string().starts_with('.'); }

std::vector<ListedImage> images_of_folder(const std::string& folder) {
  std::vector<fs::path> files = files_of(folder);
  std::erase_if(files, is_hidden);
  const std::optional<fs::path> below = folder_with_images(files);
  std::erase_if(files, [](const fs::path& file) { return !is_image_name(file); });
  if (files.empty()) {
    throw Error(ErrorCode::file,
                fmt::format("the folder '{}' has no image files (jpg, png, bmp, tif, webp, ppm, ...){}", folder,
                            below ? fmt::format(", but '{}' has: give that", below->string()) : std::string()));
  }
  return numbered_from_zero(std::move(files));
}

std::vector<ListedImage> images_of_glob(const std::string& pattern) {
  glob_t matches{};
  glob(pattern.c_str(), GLOB_TILDE, nullptr, &matches);
  std::vector<fs::path> files(matches.gl_pathv, matches.gl_pathv + matches.gl_pathc);
  globfree(&matches);
  if (files.empty()) {
    throw Error(ErrorCode::file, fmt::format("no file matches the pattern '{}'", pattern));
  }
  return numbered_from_zero(std::move(files));
}

std::string escaped_for_regex(const std::string& text) {
  static const std::regex special(R"([.^$|()\[\]{}*+?\\])");
  return std::regex_replace(text, special, R"(\$&)");
}

/// `number` stands in the pattern's file name, as one conversion.
std::vector<ListedImage> images_of_printf(const std::string& pattern, const std::smatch& number) {
  const fs::path folder = fs::path(pattern).parent_path();
  const std::string before = fs::path(number.prefix().str()).filename().string();
  const std::string after = number.suffix().str();
  if (after.find('/') != std::string::npos) {
    throw Error(ErrorCode::file,
                fmt::format("the pattern '{}' has its number in a folder's name: it must be in the file's", pattern));
  }
  const std::size_t width = number[1].length() > 0 ? std::stoul(number[1].str()) : 1;
  const std::regex name(escaped_for_regex(before) + "([0-9]{1,19})" + escaped_for_regex(after));
  std::vector<ListedImage> images;
  for (const fs::path& file : files_of(folder.empty() ? "." : folder)) {
    std::smatch digits;
    const std::string text = file.filename().string();
    if (std::regex_match(text, digits, name)) {
      const std::string written = digits[1].str();  // time stamps in nanoseconds have 19 digits
      std::int64_t index = INT64_MAX;
      std::from_chars(written.data(), written.data() + written.size(), index);
      if (index < INT64_MAX && written == fmt::format("{:0{}}", index, width)) {
        images.push_back({file, index});
      }
    }
  }
  if (images.empty()) {
    throw Error(ErrorCode::file, fmt::format("no file matches the pattern '{}'", pattern));
  }
  std::sort(images.begin(), images.end(), [](const ListedImage& a, const ListedImage& b) { return a.index < b.index; });
  return images;
}

std::string lower_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

}  // namespace

bool is_image_name(const fs::path& path) {
  const std::string extension = lower_extension(path);
  return std::find(kImageExtensions.begin(), kImageExtensions.end(), extension) != kImageExtensions.end();
}

std::optional<std::string> other_images(const std::vector<ListedImage>& images) {
  struct Kind {
    std::size_t count = 0;
    fs::path first;
  };
  std::map<std::string, Kind> kinds;  // by the extension, then the rest of the name without its digits
  std::size_t extensions = 0;
  std::string before;
  for (const ListedImage& image : images) {
    std::string name = image.path.stem().string();
    std::erase_if(name, [](unsigned char c) { return std::isdigit(c) != 0; });
    Kind& kind = kinds[lower_extension(image.path) + "/" + name];
    if (kind.count++ == 0) kind.first = image.path;
  }
  for (const auto& [name, kind] : kinds) {
    const std::string extension = name.substr(0, name.find('/'));
    extensions += extension != before ? 1 : 0;
    before = extension;
  }
  const std::size_t each = kinds.empty() ? 0 : kinds.begin()->second.count;
  const bool paired = kinds.size() == 2 && each > 1 && 2 * each == images.size();
  if (extensions < 2 && !paired) return std::nullopt;
  return fmt::format(
      "images of several kinds are taken for frames, such as '{}' and '{}': are there copies, masks or previews "
      "among them? give a pattern in quotes that only the frames match, or move the others away",
      kinds.begin()->second.first.string(), kinds.rbegin()->second.first.string());
}

bool natural_less(const std::string& a, const std::string& b) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      const auto number = [&](const std::string& text, std::size_t& at) {
        const std::size_t begin = std::min(text.find_first_not_of('0', at), text.size());
        at = begin;
        while (at < text.size() && is_digit(text[at])) {
          ++at;
        }
        return std::string_view(text).substr(begin, at - begin);
      };
      const std::string_view of_a = number(a, i);
      const std::string_view of_b = number(b, j);
      if (of_a != of_b) {
        return of_a.size() != of_b.size() ? of_a.size() < of_b.size() : of_a < of_b;
      }
    } else if (a[i] != b[j]) {
      return a[i] < b[j];
    } else {
      ++i;
      ++j;
    }
  }
  if (i < a.size() || j < b.size()) {
    return i == a.size();
  }
  return a < b;  // equal but for leading zeros
}

std::optional<std::vector<ListedImage>> list_images(const std::string& input) {
  std::error_code failed;
  if (fs::is_directory(input, failed)) {
    return images_of_folder(input);
  }
  if (fs::exists(input, failed)) {
    const std::string extension = lower_extension(input);
    const bool stream = extension == ".mjpeg" || extension == ".mjpg";  // begins as a picture does
    if (is_image_name(input) || (!stream && cv::haveImageReader(input))) {
      return std::vector<ListedImage>{{input, 0}};
    }
    return std::nullopt;
  }
  std::smatch number;
  static const std::regex conversion("%0?([0-9]{0,2})d");
  if (std::regex_search(input, number, conversion)) {
    return images_of_printf(input, number);
  }
  if (input.find_first_of("*?[") != std::string::npos && input.find("://") == std::string::npos) {
    return images_of_glob(input);
  }
  return std::nullopt;
}

}  // namespace holdfast::app
