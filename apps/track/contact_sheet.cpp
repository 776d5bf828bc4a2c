#include "track/contact_sheet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <string_view>

#include "holdfast/error.hpp"
#include "track/output_file.hpp"

namespace holdfast::app {
namespace {

constexpr int kTileWidth = 320;
constexpr int kGap = 4;

/// Distance of the frames kept of a run this long, a power of two: at least 2 `frames` are kept of a longer run.
std::int64_t step_of(std::int64_t length, std::int64_t frames) {
  std::int64_t step = 1;
  while (length / step >= 4 * frames) {
    step *= 2;
  }
  return step;
}

/// The `i`-th of `count` numbers spread evenly over [0, last].
std::int64_t spread_index(std::int64_t i, std::int64_t count, std::int64_t last) {
  return count > 1 ? (i * last + (count - 1) / 2) / (count - 1) : last / 2;
}

}  // namespace

ContactSheet::ContactSheet(const std::filesystem::path& path, int frames, std::optional<std::int64_t> expected)
    : path_(path), frames_(frames), first_step_(step_of(expected.value_or(0), std::max(1, frames))) {
  if (frames < 1) {
    throw Error(ErrorCode::invalid_argument, fmt::format("--contact-frames {} is not positive", frames));
  }
  if (!cv::haveImageWriter(path.string())) {
    throw Error(ErrorCode::output,
                fmt::format("cannot write '{}': the name of a picture must end in .png or .jpg", path.string()));
  }
  require_writable(path);
}

std::int64_t ContactSheet::step_at(std::int64_t ordinal) const {
  return std::max(first_step_, step_of(ordinal, frames_));
}

bool ContactSheet::wants(std::int64_t ordinal) const { return ordinal % step_at(ordinal) == 0; }

void ContactSheet::add(const TrackedFrame& tracked, const cv::Mat& picture) {
  const std::int64_t step = step_at(tracked.ordinal);
  std::erase_if(tiles_, [step](const Tile& tile) { return tile.ordinal % step != 0; });
  cv::Mat tile;
  const double scale = static_cast<double>(kTileWidth) / picture.cols;
  cv::resize(picture, tile, {kTileWidth, std::max(1, static_cast<int>(std::lround(picture.rows * scale)))}, 0, 0,
             cv::INTER_AREA);
  const bool held = tracked.result.status == Status::held;
  const std::string label = fmt::format("{}{}", tracked.frame.index, held ? "" : "  LOST");
  const int width = cv::getTextSize(label, cv::FONT_HERSHEY_SIMPLEX, 0.5, 1, nullptr).width;
  cv::rectangle(tile, {0, 0, width + 12, 20}, {28, 26, 24}, cv::FILLED);
  cv::putText(tile, label, {6, 15}, cv::FONT_HERSHEY_SIMPLEX, 0.5,
              held ? cv::Scalar(235, 235, 235) : cv::Scalar(60, 60, 255), 1, cv::LINE_AA);
  tiles_.push_back({tracked.ordinal, std::move(tile)});
}

void ContactSheet::finish() const {
  if (tiles_.empty()) {
    return;
  }
  const std::int64_t count = std::min<std::int64_t>(frames_, static_cast<std::int64_t>(tiles_.size()));
  const int columns = static_cast<int>(std::min<std::int64_t>(count, count <= 4 ? 2 : count <= 12 ? 4 : 5));
  const int rows = (static_cast<int>(count) + columns - 1) / columns;
  const cv::Size tile = tiles_.front().picture.size();
  cv::Mat sheet(rows * (tile.height + kGap) + kGap, columns * (tile.width + kGap) + kGap, CV_8UC3,
                cv::Scalar(28, 26, 24));
  for (std::int64_t i = 0; i < count; ++i) {
    const Tile& shown =
        tiles_[static_cast<std::size_t>(spread_index(i, count, static_cast<std::int64_t>(tiles_.size()) - 1))];
    const int column = static_cast<int>(i) % columns;
    const int row = static_cast<int>(i) / columns;
    shown.picture.copyTo(sheet(
        cv::Rect({kGap + column * (tile.width + kGap), kGap + row * (tile.height + kGap)}, shown.picture.size())));
  }
  std::vector<std::uint8_t> encoded;
  cv::imencode(path_.extension().string(), sheet, encoded);
  write_whole(path_, {reinterpret_cast<const char*>(encoded.data()), encoded.size()});
}

}  // namespace holdfast::app
