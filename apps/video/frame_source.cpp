#include "video/frame_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <utility>
#include <vector>

#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "modules/video_module.hpp"
#include "video/camera_reader.hpp"
#include "video/image_list.hpp"
#include "video/media_check.hpp"
#include "video/reader.hpp"

namespace holdfast::app {
namespace {

namespace fs = std::filesystem;

/// Of 255: a first frame without a brighter value shows next to nothing.
constexpr double kNearlyBlack = 32;

class ImageReader : public Reader {
 public:
  /// Frames before `start` may be missing.
  ImageReader(std::vector<ListedImage> images, std::int64_t start, double frame_rate)
      : images_(std::move(images)),
        time_origin_(images_.front().index),
        end_index_(images_.back().index + 1),
        frame_rate_(frame_rate > 0 ? frame_rate : kImageFrameRate),
        doubt_(other_images(images_)) {
    std::erase_if(images_, [start](const ListedImage& image) { return image.index < start; });
  }

  bool read(Frame& frame) override {
    if (at_ == images_.size()) {
      return false;
    }
    require_no_gap();
    const ListedImage& image = images_[at_++];
    read_bytes(image);
    const auto why_not = [&](const std::string& reason) {
      const std::string otherwise =
          read_any_ ? fmt::format(", or end before it with --stop {}", image.index) : std::string();
      return Error(ErrorCode::file, fmt::format("cannot read frame {}, '{}': {}; replace the file{}", image.index,
                                                image.path.string(), reason, otherwise));
    };
    if (const auto damage = image_damage(bytes_)) {
      throw why_not(*damage);
    }
    // Decoding into the frame's own memory would leave the frame before there, unnoticed, when decoding fails.
    try {
      if (!bytes_.empty()) io::check_image(bytes_.data(), bytes_.size(), image.path.string());
      frame.image = bytes_.empty() ? cv::Mat() : cv::imdecode(bytes_, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
    } catch (const cv::Exception&) {  // some decoders throw where others return nothing
      frame.image.release();
    } catch (const Error& error) {
      throw why_not(error.what());
    }
    if (frame.image.empty()) {
      throw why_not(bytes_.empty() ? "it is empty" : "it is no image that can be decoded, or it is damaged");
    }
    read_any_ = true;
    frame.index = image.index;
    frame.time_s = static_cast<double>(image.index - time_origin_) / frame_rate_;
    return true;
  }

  bool skip() override {
    if (at_ == images_.size()) {
      return false;
    }
    require_no_gap();
    ++at_;
    return true;
  }

  std::int64_t first_index() const override { return images_.empty() ? end_index_ : images_.front().index; }
  std::optional<std::int64_t> end_index() const override { return end_index_; }
  double frame_rate() const override { return frame_rate_; }
  std::string name_of_last() const override { return fmt::format(" ('{}')", images_[at_ - 1].path.string()); }
  int turn() const override { return io::image_turn(bytes_.data(), bytes_.size()); }
  std::optional<std::string> doubt() const override { return doubt_; }

 private:
  void require_no_gap() {
    if (at_ > 0 && images_[at_].index != images_[at_ - 1].index + 1) {
      const std::int64_t before = images_[at_ - 1].index;
      throw Error(ErrorCode::file,
                  fmt::format("frame {} is missing: after '{}' comes '{}'; number the images without gaps, or "
                              "give their folder",
                              before + 1, images_[at_ - 1].path.string(), images_[at_].path.filename().string()));
    }
  }

  void read_bytes(const ListedImage& image) {
    std::ifstream file(image.path, std::ios::binary | std::ios::ate);
    if (!file || fs::is_directory(image.path)) {
      throw Error(ErrorCode::file, fmt::format("cannot read frame {}, '{}': {}", image.index, image.path.string(),
                                               file ? "it is a folder" : std::strerror(errno)));
    }
    bytes_.resize(static_cast<std::size_t>(file.tellg()));
    file.seekg(0);
    file.read(reinterpret_cast<char*>(bytes_.data()), static_cast<std::streamsize>(bytes_.size()));
    bytes_.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  }

  std::vector<ListedImage> images_;
  std::int64_t time_origin_;
  std::int64_t end_index_;
  double frame_rate_;
  std::optional<std::string> doubt_;
  std::size_t at_ = 0;  // the next image
  bool read_any_ = false;
  std::vector<std::uint8_t> bytes_;
};

bool is_camera_number(const std::string& input) {
  return !input.empty() && input.size() <= 3 && input.find_first_not_of("0123456789") == std::string::npos &&
         !fs::exists(input);
}

std::unique_ptr<Reader> open_reader(const std::string& input, const FrameSourceOptions& options) {
  if (is_camera_number(input)) {
    const int number = std::stoi(input);
    return std::make_unique<CameraReader>(
        number, [number] { return video_module().open_camera(number); }, options);
  }
  if (auto images = list_images(input)) {
    return std::make_unique<ImageReader>(std::move(*images), options.start, options.frame_rate);
  }
  return open_video(input, options.frame_rate);
}

void validate(const FrameSourceOptions& options) {
  const auto require = [](bool good, const std::string& message) {
    if (!good) {
      throw Error(ErrorCode::invalid_argument, message);
    }
  };
  require(options.start >= 0, fmt::format("--start {} is negative: frames count from 0", options.start));
  require(options.stride >= 1, fmt::format("--stride {} is not positive: 1 takes every frame", options.stride));
  require(!options.stop || *options.stop > options.start,
          fmt::format("--stop {} leaves no frame after --start {}: it is the first frame not taken",
                      options.stop.value_or(0), options.start));
  require(options.frame_rate >= 0 && std::isfinite(options.frame_rate),
          fmt::format("--frame-rate {} is not positive", options.frame_rate));
}

}  // namespace

class FrameSource::Impl {
 public:
  Impl(const std::string& input, const FrameSourceOptions& given)
      : input_(input), options_((validate(given), given)), reader_(open_reader(input, given)) {
    if (const auto end = reader_->end_index(); end && reader_->end_is_certain() && *end <= options_.start) {
      throw behind_the_end(*end);
    }
    // Numbered images need not begin at 0.
    at_ = reader_->first_index();
    options_.start = std::max(options_.start, at_);
    next_wanted_ = options_.start;
    if (options_.stop && *options_.stop <= options_.start) {
      throw Error(ErrorCode::invalid_argument, fmt::format("--stop {} leaves no frame of '{}', whose first is {}",
                                                           *options_.stop, input, options_.start));
    }
    if (!read(first_)) {
      if (at_ > 0 && at_ < options_.start) throw behind_the_end(at_);
      throw Error(
          ErrorCode::file,
          ended_early_.value_or(fmt::format(
              "no frame of '{}' can be decoded: it is damaged, or of a codec that FFmpeg does not know", input)));
    }
    size_ = first_.image.size();
    has_first_ = true;
    doubt_ = reader_->doubt();
    double brightest = 0;
    cv::minMaxLoc(first_.image.reshape(1), nullptr, &brightest);
    const auto doubt = [this](const std::string& other) { doubt_ = doubt_ ? *doubt_ + "; " + other : other; };
    if (const int turn = reader_->turn(); turn != 0) {
      doubt(fmt::format(
          "frame {}{} is stored turned by {} degrees and read so, {}x{}: the calibration, the first pose and points "
          "must belong to frames as they are stored; turn the recording if they do not",
          first_.index, reader_->name_of_last(), turn, size_.width, size_.height));
    } else if (brightest < kNearlyBlack) {
      doubt(fmt::format(
          "frame {}{} is nearly black, its brightest value {} of 255: expose longer; if its values are 10 or 12 bits "
          "in 16, scale them up",
          first_.index, reader_->name_of_last(), brightest));
    }
  }

  bool next(Frame& frame) {
    if (has_first_) {
      has_first_ = false;
      std::swap(frame, first_);
      first_ = {};
      return true;
    }
    if (!read(frame)) {
      return false;
    }
    if (frame.image.size() != size_) {
      throw Error(ErrorCode::image,
                  fmt::format("frame {}{} is {}x{} pixels, the frames before it are {}x{}: one calibration holds for "
                              "one size; end before it with --stop {}",
                              frame.index, reader_->name_of_last(), frame.image.cols, frame.image.rows, size_.width,
                              size_.height, frame.index));
    }
    return true;
  }

  std::optional<std::int64_t> frame_count() const {
    std::optional<std::int64_t> end = reader_->end_index();
    if (options_.stop && (!end || *options_.stop < *end)) {
      end = options_.stop;
    }
    if (!end || (reader_->live() && !options_.stop)) {
      return std::nullopt;
    }
    return (*end - options_.start + options_.stride - 1) / options_.stride;
  }

  cv::Size size_;
  std::optional<std::string> doubt_;
  std::optional<std::string> ended_early_;
  const Reader& reader() const { return *reader_; }

 private:
  Error behind_the_end(std::int64_t end) const {
    return Error(
        ErrorCode::invalid_argument,
        fmt::format("--start {} lies behind the end of '{}', whose last frame is {}", options_.start, input_, end - 1));
  }

  std::int64_t wanted_end() const { return options_.stop.value_or(INT64_MAX); }

  bool read(Frame& frame) {
    if (next_wanted_ >= wanted_end()) {
      return false;
    }
    for (; at_ < next_wanted_; ++at_) {
      if (!reader_->skip()) {
        ended_early_ = reader_->ended_early(wanted_end());
        return false;
      }
    }
    if (!reader_->read(frame)) {
      ended_early_ = reader_->ended_early(wanted_end());
      return false;
    }
    ++at_;
    next_wanted_ += options_.stride;
    return true;
  }

  std::string input_;
  FrameSourceOptions options_;
  std::unique_ptr<Reader> reader_;
  std::int64_t at_ = 0;           // index of the frame that the reader stands before
  std::int64_t next_wanted_ = 0;  // index of the frame to deliver next
  Frame first_;
  bool has_first_ = false;
};

FrameSource::FrameSource(const std::string& input, const FrameSourceOptions& options)
    : impl_(std::make_unique<Impl>(input, options)) {}
FrameSource::~FrameSource() = default;
FrameSource::FrameSource(FrameSource&&) noexcept = default;
FrameSource& FrameSource::operator=(FrameSource&&) noexcept = default;

bool FrameSource::next(Frame& frame) { return impl_->next(frame); }
cv::Size FrameSource::size() const { return impl_->size_; }
std::optional<std::int64_t> FrameSource::frame_count() const { return impl_->frame_count(); }
double FrameSource::frame_rate() const { return impl_->reader().frame_rate(); }
bool FrameSource::live() const { return impl_->reader().live(); }
std::optional<std::string> FrameSource::doubt() const { return impl_->doubt_; }
std::optional<std::string> FrameSource::ended_early() const { return impl_->ended_early_; }

}  // namespace holdfast::app
