#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

/// Damage that decoders hide: they conceal what is missing and hand out a picture with a grey or stale rest.
namespace holdfast::app {

/// Why a video file cannot be whole, in words ("it ends at byte 4096 of 8192"); nothing for whole files, for containers
/// other than MP4, MOV and AVI, and for what is no regular file.
std::optional<std::string> video_damage(const std::filesystem::path& path);

/// What a video file's count of frames is worth.
struct CountPromise {
  bool exact = false;                ///< the container counts its frames, and does not estimate them
  std::optional<double> duration_s;  ///< of what is shown, which an edit list may leave frames out of
};

CountPromise count_promise(const std::filesystem::path& path);

/// True for a file that begins as a recording of pictures or sound: MP4, MOV, AVI, WAV, MKV, WebM, Ogg.
bool is_recording(const std::filesystem::path& path);

/// Why an encoded image cannot be whole; nothing for whole images and for formats other than JPEG and PNG.
std::optional<std::string> image_damage(std::span<const std::uint8_t> bytes);

}  // namespace holdfast::app
