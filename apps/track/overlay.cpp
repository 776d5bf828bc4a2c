#include "track/overlay.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

namespace holdfast::app {
namespace {

constexpr int kStripHeight = 52;
// Panels neither too small for the text below them nor too large to play.
constexpr double kNarrowestPanel = 560;
constexpr double kWidestPanel = 960;
constexpr int kSubpixelBits = 4;

const cv::Scalar kHeldColor(120, 255, 90);
const cv::Scalar kLostColor(60, 60, 255);
const cv::Scalar kTextColor(235, 235, 235);
const cv::Scalar kDimTextColor(165, 165, 165);
const cv::Scalar kStripColor(28, 26, 24);

struct ClassStyle {
  cv::Vec3b color;
  double opacity;
};

/// Marked pixels of a contour are single: this makes them large enough to be seen.
constexpr int kDotRadius = 2;

/// By value of PixelClass.
const std::array<ClassStyle, 7> kClassStyles = {{{{0, 0, 0}, 0},
                                                 {{200, 150, 110}, 0.35},
                                                 {{190, 190, 190}, 0.25},
                                                 {{30, 30, 255}, 0.75},
                                                 {{20, 110, 255}, 0.75},
                                                 {{150, 40, 190}, 0.75},
                                                 {{60, 230, 40}, 0.7}}};

struct LegendEntry {
  PixelClass shown;
  const char* word;
};

const std::vector<LegendEntry> kPixelLegend = {{PixelClass::used, "used"},
                                               {PixelClass::rejected_angle, "angle"},
                                               {PixelClass::rejected_magnitude, "difference"},
                                               {PixelClass::rejected_vote, "vote"},
                                               {PixelClass::no_gradient, "flat"}};
const std::vector<LegendEntry> kContourLegend = {{PixelClass::used, "edge is there"},
                                                 {PixelClass::rejected_magnitude, "edge is elsewhere"},
                                                 {PixelClass::no_gradient, "colours alike"}};

const ClassStyle& style_of(PixelClass shown) { return kClassStyles[static_cast<std::size_t>(shown)]; }

/// The mask marks lines across the contour in place of the texture's pixels.
bool shows_contour(const FrameResult& result) { return !result.texture.holds && result.contour.asked; }

double percent(double part, double whole) { return whole > 0 ? 100 * part / whole : 0; }

double panel_scale(const Camera& camera) {
  const double width = camera.width;
  return std::clamp(width, kNarrowestPanel, kWidestPanel) / width;
}

cv::Size panel_size(const Camera& camera) {
  // Even, as video encoders want it.
  const auto even = [](double value) { return std::max(2, static_cast<int>(std::lround(value / 2)) * 2); };
  const double scale = panel_scale(camera);
  return {even(camera.width * scale), even(camera.height * scale)};
}

/// Length of a drawn axis, in radii of the model.
constexpr double kAxis = 0.7;
const std::array<cv::Scalar, 3> kAxisColors{cv::Scalar(70, 70, 240), cv::Scalar(80, 200, 80), cv::Scalar(240, 140, 60)};

constexpr double kTextSize = 0.46;
constexpr double kSmallTextSize = 0.42;

int width_of(const std::string& text, double size) {
  return cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 1, nullptr).width;
}

/// Text with its left end at x, made smaller where it would reach `limit`; returns where the next may begin.
int put_text(cv::Mat& image, const std::string& text, int x, int baseline, const cv::Scalar& color, double size,
             int limit) {
  const int width = width_of(text, size);
  if (x + width > limit) size *= static_cast<double>(limit - x) / width;
  cv::putText(image, text, {x, baseline}, cv::FONT_HERSHEY_SIMPLEX, size, color, 1, cv::LINE_AA);
  return x + std::min(width, limit - x);
}

}  // namespace

Overlay::Overlay(const Mesh& mesh, const Camera& camera)
    : camera_(camera),
      p_object_center_(mesh.center()),
      radius_(mesh.radius()),
      outline_(mesh, camera),
      scale_(panel_scale(camera)),
      panel_size_(panel_size(camera)) {
  if (camera.has_distortion()) {
    map_x_.create(camera.height, camera.width, CV_32F);
    map_y_.create(camera.height, camera.width, CV_32F);
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x) {
        const Eigen::Vector2d recorded = camera.distort({x, y});
        map_x_.at<float>(y, x) = static_cast<float>(recorded.x());
        map_y_.at<float>(y, x) = static_cast<float>(recorded.y());
      }
    }
  }
}

cv::Size Overlay::overlay_size() const { return {2 * panel_size_.width, panel_size_.height + kStripHeight}; }

cv::Size Overlay::window_size() const { return {panel_size_.width, panel_size_.height + kStripHeight}; }

void Overlay::undistort(const cv::Mat& image) {
  if (map_x_.empty()) {
    cv::resize(image, panel_, panel_size_, 0, 0, scale_ < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
    return;
  }
  cv::remap(image, straight_, map_x_, map_y_, cv::INTER_LINEAR);
  cv::resize(straight_, panel_, panel_size_, 0, 0, scale_ < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
}

cv::Point Overlay::fixed_point(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d scaled = (((pixel.array() + 0.5) * scale_ - 0.5) * (1 << kSubpixelBits)).round();
  return {static_cast<int>(scaled.x()), static_cast<int>(scaled.y())};
}

void Overlay::draw_axes(const Pose& T_camera_object, cv::Mat& panel) const {
  const Eigen::Vector3d p_center = T_camera_object * p_object_center_;
  if (p_center.z() <= radius_) return;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d p_end = p_center + kAxis * radius_ * T_camera_object.linear().col(axis);
    cv::line(panel, fixed_point(camera_.project(p_center)), fixed_point(camera_.project(p_end)),
             kAxisColors[static_cast<std::size_t>(axis)], 2, cv::LINE_AA, kSubpixelBits);
  }
}

void Overlay::draw_outline(const TrackedFrame& tracked, cv::Mat& panel) {
  if (!tracked.located) return;
  const std::vector<Line>& lines = outline_.lines(tracked.result.T_camera_object);
  const auto draw = [&](const cv::Scalar& color, int thickness) {
    for (const Line& line : lines) {
      cv::line(panel, fixed_point(line.begin), fixed_point(line.end), color, thickness, cv::LINE_AA, kSubpixelBits);
    }
  };
  draw({0, 0, 0}, 4);  // a dark rim keeps the lines visible on any background
  draw(tracked.result.status == Status::held ? kHeldColor : kLostColor, 2);
}

void Overlay::draw_decisions(const TrackedFrame& tracked, cv::Mat& panel) {
  const PixelMask& mask = tracked.mask;
  cv::cvtColor(panel_, grey_, cv::COLOR_BGR2GRAY);
  cv::cvtColor(grey_, grey_bgr_, cv::COLOR_GRAY2BGR);
  if (mask.classes.empty()) {  // nothing was looked at
    classes_.create(panel_size_, CV_8U);
    classes_.setTo(0);
  } else {
    const cv::Mat given(mask.height, mask.width, CV_8U, const_cast<std::uint8_t*>(mask.classes.data()));
    cv::resize(given, classes_, panel_size_, 0, 0, cv::INTER_NEAREST);
  }
  for (int y = 0; y < panel.rows; ++y) {
    const std::uint8_t* classes = classes_.ptr<std::uint8_t>(y);
    const cv::Vec3b* grey = grey_bgr_.ptr<cv::Vec3b>(y);
    cv::Vec3b* out = panel.ptr<cv::Vec3b>(y);
    for (int x = 0; x < panel.cols; ++x) {
      const std::size_t index = std::min<std::size_t>(classes[x], kClassStyles.size() - 1);
      const ClassStyle& style = kClassStyles[index];
      const double light = index == 0 ? 0.45 : 0.9;  // what the object does not cover steps back
      for (int c = 0; c < 3; ++c) {
        out[x][c] = cv::saturate_cast<std::uint8_t>((1 - style.opacity) * light * grey[x][c] +
                                                    style.opacity * style.color[c] * (0.5 + 0.5 * grey[x][c] / 255));
      }
    }
  }
  if (shows_contour(tracked.result)) draw_contour_dots(mask, panel);
}

void Overlay::draw_contour_dots(const PixelMask& mask, cv::Mat& panel) const {
  for (std::size_t i = 0; i < mask.classes.size(); ++i) {
    for (const LegendEntry& entry : kContourLegend) {
      if (mask.classes[i] != static_cast<std::uint8_t>(entry.shown)) continue;
      const auto width = static_cast<std::size_t>(mask.width);
      const cv::Point place = fixed_point({static_cast<double>(i % width), static_cast<double>(i / width)});
      cv::circle(panel, place, kDotRadius << kSubpixelBits, cv::Scalar(style_of(entry.shown).color), cv::FILLED,
                 cv::LINE_AA, kSubpixelBits);
    }
  }
}

void Overlay::draw_figures(const TrackedFrame& tracked, cv::Mat& strip) {
  strip.setTo(kStripColor);
  const FrameResult& result = tracked.result;
  const bool held = result.status == Status::held;
  const int upper = 21;
  const int lower = 43;
  cv::rectangle(strip, {8, upper - 14, 54, 19}, held ? kHeldColor : kLostColor, cv::FILLED);
  const int panel = panel_size_.width, limit = panel - 10;
  put_text(strip, held ? "HELD" : "LOST", 14, upper, {10, 10, 10}, kTextSize, limit);
  const bool by_contour = shows_contour(result);
  put_text(strip,
           fmt::format("frame {}   {:.2f} s   {}   {:.1f} ms", tracked.frame.index, tracked.frame.time_s,
                       by_contour ? fmt::format("residual {:.2f} px   contour {:.2f}", result.contour.residual,
                                                result.contour.score())
                                  : fmt::format("residual {:.3f}   correlation {:.2f}", result.texture.residual,
                                                result.texture.correlation),
                       result.ms.total),
           74, upper, kTextColor, kTextSize, limit);
  std::array<int, kClassStyles.size()> counts{};
  for (const std::uint8_t value : tracked.mask.classes) {
    ++counts[std::min<std::size_t>(value, counts.size() - 1)];
  }
  if (!result.message.empty()) {
    put_text(strip, result.message, 10, lower, held ? kTextColor : kLostColor, kSmallTextSize, limit);
  } else {
    // All of them, as they are coloured, not only those of the rows that the pose came from.
    const int used = counts[static_cast<std::size_t>(PixelClass::used)];
    const int visible = std::accumulate(counts.begin() + 1, counts.end(), 0);
    const std::string share =
        by_contour
            ? fmt::format("{} of {} lines across the contour find its edge ({:.0f} %)", result.contour.near_lines,
                          result.contour.lines, percent(result.contour.near_lines, result.contour.lines))
            : fmt::format("{} of {} visible pixels used ({:.0f} %)", used, visible, percent(used, visible));
    put_text(strip, share, 10, lower, kDimTextColor, kSmallTextSize, limit);
  }

  put_text(strip, by_contour ? "contour" : "pixels", panel + 10, upper, kDimTextColor, kTextSize, strip.cols);
  int x = panel + (by_contour ? 80 : 70);
  for (const LegendEntry& entry : by_contour ? kContourLegend : kPixelLegend) {
    cv::rectangle(strip, {x, upper - 11, 12, 12}, cv::Scalar(style_of(entry.shown).color), cv::FILLED);
    const std::string count = fmt::format("{}", counts[static_cast<std::size_t>(entry.shown)]);
    const int end = put_text(strip, entry.word, x + 17, upper, kTextColor, kTextSize, strip.cols);
    put_text(strip, count, x + 17, lower, kDimTextColor, kSmallTextSize, x + 17 + 66);
    x = std::max(end, x + 70) + 14;
  }
}

const cv::Mat& Overlay::outline_picture(const TrackedFrame& tracked) {
  undistort(tracked.frame.image);
  draw_outline(tracked, panel_);
  return panel_;
}

void Overlay::draw_status(const TrackedFrame& tracked, const std::string& note, cv::Mat& strip) const {
  strip.setTo(kStripColor);
  const FrameResult& result = tracked.result;
  const bool held = result.status == Status::held;
  const int upper = 21, lower = 43, limit = panel_size_.width - 10;
  cv::rectangle(strip, {8, upper - 14, 54, 19}, held ? kHeldColor : kLostColor, cv::FILLED);
  put_text(strip, held ? "HELD" : "LOST", 14, upper, {10, 10, 10}, kTextSize, limit);
  put_text(strip, fmt::format("frame {}   {}", tracked.frame.index, result.message), 74, upper, kTextColor, kTextSize,
           limit);
  put_text(strip, note, 10, lower, kDimTextColor, kSmallTextSize, limit);
}

const cv::Mat& Overlay::window_picture(const TrackedFrame& tracked, bool decisions, const std::string& note) {
  undistort(tracked.frame.image);
  picture_.create(panel_size_.height + kStripHeight, panel_size_.width, CV_8UC3);
  cv::Mat panel = picture_.rowRange(0, panel_size_.height),
          strip = picture_.rowRange(panel_size_.height, picture_.rows);
  if (decisions) {
    draw_decisions(tracked, panel);
  } else {
    panel_.copyTo(panel);
  }
  draw_outline(tracked, panel);
  if (tracked.located) draw_axes(tracked.result.T_camera_object, panel);
  draw_status(tracked, note, strip);
  return picture_;
}

const cv::Mat& Overlay::overlay_picture(const TrackedFrame& tracked) {
  undistort(tracked.frame.image);
  picture_.create(overlay_size(), CV_8UC3);
  cv::Mat left = picture_(cv::Rect({0, 0}, panel_size_));
  cv::Mat right = picture_(cv::Rect({panel_size_.width, 0}, panel_size_));
  cv::Mat strip = picture_.rowRange(panel_size_.height, picture_.rows);
  draw_decisions(tracked, right);
  panel_.copyTo(left);
  draw_outline(tracked, left);
  draw_figures(tracked, strip);
  return picture_;
}

}  // namespace holdfast::app
