#include "simulation/background.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "holdfast/error.hpp"
#include "modules/video_module.hpp"
#include "simulation/light_encoding.hpp"
#include "simulation/random.hpp"

namespace holdfast::simulation {
namespace {

// Muted colours are common and saturated ones rare, as in rooms.
cv::Vec3f thing_color(Random& random) {
  const double hue = 6.0 * random.uniform();
  const double saturation = 0.75 * random.uniform() * random.uniform();
  const double value = 20.0 + 225.0 * std::sqrt(random.uniform()) * random.uniform(0.5, 1.0);
  cv::Vec3f color;
  for (int k = 0; k < 3; ++k) {
    const double distance = std::abs(std::fmod(hue + 2.0 * k, 6.0) - 3.0);
    color[k] = static_cast<float>(value * (1.0 - saturation * std::clamp(2.0 - distance, 0.0, 1.0)));
  }
  return color;
}

std::vector<cv::Point> outline(Random& random, double radius) {
  const int corners = random.uniform() < 0.45 ? 4 : random.uniform() < 0.5 ? 24 : 3 + random.below(5);
  const double stretch = random.uniform(0.35, 1.0);
  const double turn = random.uniform() < 0.5 ? random.uniform(-0.08, 0.08) : random.uniform(0, std::numbers::pi);
  const double first = corners == 4 ? std::numbers::pi / 4 : random.uniform(0, std::numbers::pi);
  std::vector<cv::Point> points;
  for (int i = 0; i < corners; ++i) {
    const double angle = first + 2.0 * std::numbers::pi * i / corners;
    const double x = radius * std::cos(angle);
    const double y = radius * stretch * std::sin(angle);
    // Four bits of subpixel position (fillPoly's shift).
    points.emplace_back(cvRound(16 * (x * std::cos(turn) - y * std::sin(turn))),
                        cvRound(16 * (x * std::sin(turn) + y * std::cos(turn))));
  }
  return points;
}

void add_thing(cv::Mat& picture, Random& random, double radius) {
  const double center_x = random.uniform(-0.05, 1.05) * picture.cols;
  const double center_y = random.uniform(-0.05, 1.05) * picture.rows;
  const cv::Vec3f color = thing_color(random);
  const double shade_angle = random.uniform(0, 2.0 * std::numbers::pi);
  const double shade = random.uniform(0.0, 0.35) / radius;
  std::vector<cv::Point> points = outline(random, radius);

  const int reach = static_cast<int>(std::ceil(radius)) + 1;
  const cv::Rect area = cv::Rect(cvFloor(center_x) - reach, cvFloor(center_y) - reach, 2 * reach + 1, 2 * reach + 1) &
                        cv::Rect({}, picture.size());
  if (area.empty()) return;
  for (cv::Point& point : points) {
    point += cv::Point(cvRound(16 * (center_x - area.x)), cvRound(16 * (center_y - area.y)));
  }
  cv::Mat cover = cv::Mat::zeros(area.size(), CV_8U);
  cv::fillPoly(cover, std::vector<std::vector<cv::Point>>{points}, 255, cv::LINE_AA, 4);
  for (int y = 0; y < area.height; ++y) {
    cv::Vec3f* row = picture.ptr<cv::Vec3f>(area.y + y) + area.x;
    for (int x = 0; x < area.width; ++x) {
      const float share = static_cast<float>(cover.at<std::uint8_t>(y, x)) / 255.0f;
      if (share == 0) continue;
      const double along =
          (area.x + x - center_x) * std::cos(shade_angle) + (area.y + y - center_y) * std::sin(shade_angle);
      row[x] = row[x] * (1 - share) + color * static_cast<float>(share * (1.0 + shade * along));
    }
  }
}

// Grain of several sizes, multiplied on.
void add_grain(cv::Mat& picture, Random& random) {
  for (int cell = 2; cell <= 64; cell *= 2) {
    cv::Mat coarse(picture.rows / cell + 2, picture.cols / cell + 2, CV_32F);
    for (int y = 0; y < coarse.rows; ++y) {
      for (int x = 0; x < coarse.cols; ++x) coarse.at<float>(y, x) = static_cast<float>(1.0 + 0.025 * random.normal());
    }
    cv::Mat fine;
    cv::resize(coarse, fine, coarse.size() * cell, 0, 0, cv::INTER_CUBIC);
    cv::Mat channels;
    cv::merge(std::vector<cv::Mat>(3, fine(cv::Rect({}, picture.size()))), channels);
    picture = picture.mul(channels);
  }
}

}  // namespace

cv::Mat procedural_picture(cv::Size size, std::uint64_t seed) {
  Random random(seed, 0xbac6);
  cv::Mat picture(size * 2, CV_32FC3);  // reduced in the end, which smooths edges as a lens does
  const cv::Vec3f wall = thing_color(random) * 0.5f + cv::Vec3f(80, 80, 80);
  for (int y = 0; y < picture.rows; ++y) {
    picture.row(y).setTo(cv::Scalar(wall * (1.15f - 0.4f * static_cast<float>(y) / static_cast<float>(picture.rows))));
  }
  // Every size class covers area, so that no scale stands out, the small ones somewhat less, as in rooms. In random
  // order, so that large things hide small ones as often as the other way round.
  const double area = static_cast<double>(picture.cols) * picture.rows;
  const double largest = 0.32 * picture.rows;
  const double smallest = std::max(3.0, 0.007 * picture.rows);
  std::vector<std::pair<std::uint64_t, double>> things;
  for (double radius = largest; radius > smallest; radius *= 0.8) {
    const double cover = 0.55 * std::sqrt(radius / largest);
    const int count = static_cast<int>(std::ceil(cover * area / (std::numbers::pi * radius * radius)));
    for (int i = 0; i < count; ++i) things.emplace_back(random.bits(), radius * random.uniform(0.85, 1.15));
  }
  std::sort(things.begin(), things.end());
  for (const auto& [order, radius] : things) add_thing(picture, random, radius);
  add_grain(picture, random);
  cv::Mat reduced, result;
  cv::resize(picture, reduced, size, 0, 0, cv::INTER_AREA);
  cv::GaussianBlur(reduced, reduced, {}, 0.7);
  reduced.convertTo(result, CV_8UC3);
  return result;
}

cv::Mat linear_from_encoded(const cv::Mat& picture) {
  cv::Mat table(1, 256, CV_32F);
  for (int i = 0; i < 256; ++i) table.at<float>(i) = static_cast<float>(linear_from_encoded(i / 255.0));
  cv::Mat result;
  cv::LUT(picture, table, result);
  return result;
}

struct Background::Video {
  std::mutex mutex;
  std::unique_ptr<cv::VideoCapture> capture;
  std::string name;
  int next = 0;    // index of the frame that the next read gives
  int length = 0;  // frames, known once the end was seen
  cv::Mat last;    // linear, frame `next - 1`
};

Background::Background(const BackgroundOptions& options, cv::Size frame_size, std::uint64_t seed)
    : size_(frame_size), pan_(options.pan) {
  if (pan_ != 0) {
    margin_ = std::max(8, frame_size.width / 8);
    phase_ = Random(seed, 0x9a2).uniform(0, 2.0 * std::numbers::pi);
  }
  const cv::Size full(frame_size.width + 2 * margin_, frame_size.height + 2 * margin_);
  if (options.file.empty()) {
    still_ = linear_from_encoded(procedural_picture(full, seed));
    return;
  }
  const std::string name = options.file.string();
  if (!std::filesystem::is_regular_file(options.file)) {
    throw Error(ErrorCode::file, name + ": no such background file; give a picture or a video");
  }
  const cv::Mat picture = cv::imread(name, cv::IMREAD_COLOR);
  if (!picture.empty()) {
    cv::Mat scaled;
    cv::resize(picture, scaled, full, 0, 0, cv::INTER_AREA);
    still_ = linear_from_encoded(scaled);
    return;
  }
  video_ = std::make_unique<Video>();
  video_->name = name;
  video_->capture = app::video_module().open_file(name);
  if (!video_->capture) {
    throw Error(ErrorCode::file, name + ": neither a picture nor a video that can be decoded; give another background");
  }
  static_cast<void>(this->picture(0));
}

Background::~Background() = default;

cv::Mat Background::picture(int frame) const {
  if (!video_) return still_;
  const std::lock_guard lock(video_->mutex);
  int wanted = video_->length > 0 ? frame % video_->length : frame;
  if (wanted + 1 == video_->next) return video_->last;
  const auto restart = [&] {
    video_->capture = app::video_module().open_file(video_->name);
    if (!video_->capture) throw Error(ErrorCode::file, video_->name + ": cannot be opened any more; leave it in place");
    video_->next = 0;
  };
  if (wanted < video_->next) restart();
  cv::Mat decoded;
  while (video_->next <= wanted) {
    if (video_->capture->read(decoded) && !decoded.empty()) {
      ++video_->next;
      continue;
    }
    if (video_->next == 0) throw Error(ErrorCode::file, video_->name + ": has no frames; give another background");
    video_->length = video_->next;
    wanted = frame % video_->length;
    restart();
  }
  cv::Mat scaled;
  cv::resize(decoded, scaled, size_ + cv::Size(2 * margin_, 2 * margin_), 0, 0, cv::INTER_AREA);
  video_->last = linear_from_encoded(scaled);
  return video_->last;
}

cv::Mat Background::at(double frame) const {
  const cv::Mat source = picture(std::max(0, cvRound(frame)));
  if (margin_ == 0) return source;
  // A figure of eight whose fastest point moves by `pan_` pixels a frame.
  const double reach = margin_ - 2;
  const double angle = phase_ + pan_ * frame / (reach * std::hypot(1.0, 1.0));
  const double x = margin_ + reach * std::sin(angle);
  const double y = margin_ + 0.5 * reach * std::sin(2.0 * angle);
  const cv::Matx23d shift(1, 0, x, 0, 1, y);
  cv::Mat result;
  cv::warpAffine(source, result, shift, size_, cv::INTER_CUBIC | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
  return result;
}

}  // namespace holdfast::simulation
