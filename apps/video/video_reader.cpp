#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "holdfast/error.hpp"
#include "modules/video_module.hpp"
#include "video/media_check.hpp"
#include "video/reader.hpp"

namespace holdfast::app {
namespace {

namespace fs = std::filesystem;

constexpr double kLongest = 1e9;  // seconds, 30 years: what is beyond stands for no time stamp

class VideoReader : public Reader {
 public:
  VideoReader(const std::string& path, double frame_rate) : path_(path) {
    const bool is_url = path.find("://") != std::string::npos;
    if (!is_url) {
      require_readable();
      damage_ = video_damage(path);
    }
    capture_ = video_module().open_file(path);
    if (!capture_) {
      const std::string reason = damage_  ? *damage_
                                 : is_url ? "it cannot be reached, or is no video"
                                 : is_recording(path)
                                     ? "it holds no video (sound alone?), or of a codec that FFmpeg does not know"
                                     : fmt::format("unknown format; {}", kInputKinds);
      throw Error(ErrorCode::file, fmt::format("cannot open '{}' as a video: {}", path, reason));
    }
    capture_->set(cv::CAP_PROP_ORIENTATION_AUTO, 0);
    turn_ = (static_cast<int>(capture_->get(cv::CAP_PROP_ORIENTATION_META)) % 360 + 360) % 360;
    const double own_rate = capture_->get(cv::CAP_PROP_FPS);
    has_rate_of_its_own_ = frame_rate <= 0 && own_rate > 0 && own_rate < 1e4;
    frame_rate_ = frame_rate > 0 ? frame_rate : has_rate_of_its_own_ ? own_rate : kImageFrameRate;
    const double count = capture_->get(cv::CAP_PROP_FRAME_COUNT);
    promised_ = count >= 1 && count < 1e12 ? static_cast<std::int64_t>(count) : 0;
    promise_ = is_url ? CountPromise{} : count_promise(path);
  }

  bool read(Frame& frame) override {
    if (!capture_->grab() || !capture_->retrieve(frame.image) || frame.image.empty()) {
      return false;
    }
    frame.index = read_++;
    // Frames need not come at regular times; containers that carry none give zeros.
    const double time_s = capture_->get(cv::CAP_PROP_POS_MSEC) * 1e-3;
    const bool plausible =
        has_rate_of_its_own_ && std::abs(time_s) < kLongest && (frame.index == 0 || time_s > last_time_s_);
    stamped_ = stamped_ || (plausible && time_s > 0);
    frame.time_s = plausible  ? time_s
                   : stamped_ ? last_time_s_ + 1 / frame_rate_  // one stamp is missing: time does not go back
                              : static_cast<double>(frame.index) / frame_rate_;
    last_time_s_ = frame.time_s;
    return true;
  }

  bool skip() override {
    const bool grabbed = capture_->grab();
    read_ += grabbed ? 1 : 0;
    return grabbed;
  }

  std::optional<std::int64_t> end_index() const override {
    return promised_ > 0 ? std::optional(promised_) : std::nullopt;
  }
  bool end_is_certain() const override { return promise_.exact && !promise_.duration_s; }
  double frame_rate() const override { return frame_rate_; }
  std::string name_of_last() const override { return fmt::format(" of '{}'", path_); }
  int turn() const override { return turn_; }

  std::optional<std::string> ended_early(std::int64_t wanted_end) const override {
    if (damage_) {
      return fmt::format("'{}' is damaged: {}; {}; copy or record it again", path_, *damage_,
                         read_ == 0 ? "no frame can be decoded"
                                    : fmt::format("{} frames could be decoded, the last may be spoiled", read_));
    }
    // Containers without a frame count have it estimated from their duration, and edit lists leave frames out.
    const std::int64_t wanted = std::min(wanted_end, promised_);
    const std::int64_t tolerance = std::max<std::int64_t>(1, promised_ / 100);
    const bool to_its_end =
        promise_.duration_s && last_time_s_ + 2 / frame_rate_ + 0.01 * *promise_.duration_s >= *promise_.duration_s;
    if (promise_.exact && !to_its_end && read_ + tolerance < wanted) {
      return fmt::format(
          "'{}' promises {} frames, but only {} can be decoded: it is damaged or cut short; copy or record it "
          "again",
          path_, promised_, read_);
    }
    return std::nullopt;
  }

 private:
  void require_readable() const {
    std::error_code failed;
    if (!fs::exists(path_, failed)) {
      throw Error(ErrorCode::file, fmt::format("there is no '{}': {}", path_, kInputKinds));
    }
    if (!std::ifstream(path_)) {
      throw Error(ErrorCode::file, fmt::format("cannot read '{}': {}", path_, std::strerror(errno)));
    }
  }

  std::string path_;
  std::unique_ptr<cv::VideoCapture> capture_;
  std::optional<std::string> damage_;
  double frame_rate_ = 0;
  int turn_ = 0;
  bool has_rate_of_its_own_ = false;
  std::int64_t promised_ = 0;  // 0: unknown
  CountPromise promise_;
  bool stamped_ = false;  // frames have had times of their own
  std::int64_t read_ = 0;
  double last_time_s_ = 0;
};

}  // namespace

std::unique_ptr<Reader> open_video(const std::string& path, double frame_rate) {
  return std::make_unique<VideoReader>(path, frame_rate);
}

}  // namespace holdfast::app
