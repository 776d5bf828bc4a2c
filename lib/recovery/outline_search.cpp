#include "recovery/outline_search.hpp"

#include <algorithm>
#include <cmath>

namespace holdfast {
namespace {

/// Widest level that is looked at, pixels.
constexpr int kWidest = 160;
/// Places by colour, and appearances at each of them and where it is expected, that a frame takes on.
constexpr std::size_t kMostPlaces = 2;
constexpr int kAppearances = 10;
/// Starts that are proposed.
constexpr std::size_t kMostStarts = 3;
/// Pixels of the level from place to place, and around a silhouette.
constexpr int kStride = 2, kAround = 4;

}  // namespace

OutlineSearch::OutlineSearch(const Device::Impl& device, const std::vector<Level>& levels, const Extent& extent,
                             DeviceImage& image, DepthView& shape)
    : device_(device),
      levels_(levels),
      extent_(extent),
      image_(image),
      keyframes_(extent.p_object_center),
      shape_(shape) {
  while (static_cast<std::size_t>(level_) + 1 < levels.size() &&
         levels[static_cast<std::size_t>(level_)].width > kWidest) {
    ++level_;
  }
  width_ = levels[static_cast<std::size_t>(level_)].width;
  height_ = levels[static_cast<std::size_t>(level_)].height;
}

void OutlineSearch::clear() {
  keyframes_.clear();
  searching_ = false;
}

void OutlineSearch::read_colors(const ColorHistograms& colors) {
  const Level& level = levels_[static_cast<std::size_t>(level_)];
  image_.enqueue_pixels(level_);
  pixels_.resize(4 * level.elements);
  device_.queue.enqueueReadBuffer(image_.pixels(level_), CL_TRUE, 0, pixels_.size() * sizeof(float), pixels_.data());
  says_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  auto out = says_.begin();
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const float* pixel = pixels_.data() + 4 * (level.layout.origin + y * level.layout.stride + x);
      *out++ = 2 * colors.share()[static_cast<std::size_t>(color_bin(pixel))] - 1;
    }
  }
}

std::vector<Eigen::Vector2d> OutlineSearch::places(const Rect& box) {
  const int width = width_, height = height_;
  const auto sum = [&](int x, int y) -> double& {
    return sums_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width + 1) + static_cast<std::size_t>(x)];
  };
  sums_.assign(static_cast<std::size_t>(width + 1) * static_cast<std::size_t>(height + 1), 0.0);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) sum(x + 1, y + 1) = says(x, y) + sum(x, y + 1) + sum(x + 1, y) - sum(x, y);
  }
  const auto inside = [&](int x, int y, int w, int h) {
    const int left = std::clamp(x, 0, width), right = std::clamp(x + w, 0, width);
    const int top = std::clamp(y, 0, height), bottom = std::clamp(y + h, 0, height);
    return sum(right, bottom) - sum(left, bottom) - sum(right, top) + sum(left, top);
  };
  const int side = 1 << level_;
  const int w = std::max(4, box.width / side), h = std::max(4, box.height / side);
  struct Place {
    double score;
    int x, y;
  };
  std::vector<Place> all;
  for (int y = -h / 2; y + h / 2 < height; y += kStride) {
    for (int x = -w / 2; x + w / 2 < width; x += kStride) {
      // The object's colours inside, and others around it.
      const double here = inside(x, y, w, h);
      const double around = inside(x - w / 4, y - h / 4, w + w / 2, h + h / 2) - here;
      all.push_back({here - 0.5 * around, x, y});
    }
  }
  std::stable_sort(all.begin(), all.end(), [](const Place& a, const Place& b) { return a.score > b.score; });
  std::vector<Eigen::Vector2d> found;
  std::vector<Place> taken;
  for (const Place& place : all) {
    if (found.size() == kMostPlaces || place.score <= 0) break;
    const auto near = [&](const Place& other) {
      return std::abs(place.x - other.x) < w / 2 && std::abs(place.y - other.y) < h / 2;
    };
    if (std::any_of(taken.begin(), taken.end(), near)) continue;
    taken.push_back(place);
    found.emplace_back((place.x + 0.5 * w + 0.5) * side - 0.5, (place.y + 0.5 * h + 0.5) * side - 0.5);
  }
  return found;
}

double OutlineSearch::contrast(const Pose& T_camera_object) {
  if (!shape_.draw(T_camera_object, level_, 0)) return -2;
  const DrawnDepth& drawn = shape_.drawn();
  const auto object = [&](int x, int y) { return drawn.at(x, y) < 1.0F; };
  double inside = 0, around = 0;
  int inside_count = 0, around_count = 0;
  const int right = std::min(width_, drawn.rect.x + drawn.rect.width);
  const int bottom = std::min(height_, drawn.rect.y + drawn.rect.height);
  for (int y = std::max(0, drawn.rect.y); y < bottom; ++y) {
    for (int x = std::max(0, drawn.rect.x); x < right; ++x) {
      if (object(x, y)) {
        inside += says(x, y);
        ++inside_count;
      } else if (object(x - kAround, y) || object(x + kAround, y) || object(x, y - kAround) || object(x, y + kAround)) {
        around += says(x, y);
        ++around_count;
      }
    }
  }
  return inside_count > 0 && around_count > 0 ? inside / inside_count - around / around_count : -2;
}

std::vector<Pose> OutlineSearch::starts(const Pose& T_last, const Pose& T_expected, const Rect& box,
                                        const ColorHistograms& colors) {
  if (!colors.known()) return {};
  if (!searching_) keyframes_.plan(T_last);
  searching_ = true;
  read_colors(colors);
  std::vector<Eigen::Vector2d> centers;
  if (!box.empty()) centers = places(box);
  const Camera& camera = levels_[0].camera;
  const Eigen::Vector3d p_expected = T_expected * extent_.p_object_center;
  if (p_expected.z() > extent_.radius) centers.push_back(camera.project(p_expected));
  struct Start {
    Pose T_camera_object;
    double contrast = 0;
  };
  std::vector<Start> all;
  for (int i = 0; i < kAppearances; ++i) {
    const Pose appearance = keyframes_.next();
    for (const Eigen::Vector2d& center : centers) {
      const Eigen::Vector3d ray((center.x() - camera.cx) / camera.fx, (center.y() - camera.cy) / camera.fy, 1);
      Pose T = Pose::Identity();
      T.linear() = Keyframes::to_axis(ray).transpose();
      T = T * appearance;
      all.push_back({T, contrast(T)});
    }
  }
  std::stable_sort(all.begin(), all.end(), [](const Start& a, const Start& b) { return a.contrast > b.contrast; });
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < std::min(kMostStarts, all.size()); ++i) poses.push_back(all[i].T_camera_object);
  return poses;
}

}  // namespace holdfast
