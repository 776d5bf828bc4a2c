#include "contour/contour_points.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace holdfast {
namespace {

/// Pixels around a contour's pixel that tell where the contour runs, and the Gaussian that weighs them.
constexpr int kAround = 3;
constexpr double kSigma = 1.2;
/// Object that must be seen inside of a point, pixels.
constexpr float kLeastInside = 2;

/// The Gaussian's distribution function, inverted by bisection: from the share of a half plane to its distance.
double distance_of_share(double share) {
  double low = -3, high = 3;
  for (int i = 0; i < 14; ++i) {
    const double middle = 0.5 * (low + high);
    (0.5 * std::erfc(-middle / std::sqrt(2.0)) < share ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// A pixel of the drawn rectangle shows the object.
bool is_object(const DrawnDepth& drawn, int x, int y) {
  return drawn.depth[static_cast<std::ptrdiff_t>(y) * drawn.rect.width + x] < 1.0F;
}

/// Marks the pixels of a row that are the object's and beside one that is not; all neighbours must be drawn.
void mark_contour(const DrawnDepth& drawn, int y, int margin, std::vector<std::uint8_t>& marks) {
  const int width = drawn.rect.width;
  const float* here = drawn.depth + static_cast<std::ptrdiff_t>(y) * width;
  const float *above = here - width, *below = here + width;
  std::uint8_t* mark = marks.data();  // the vector's own pointer may change by what is stored through it
  for (int x = margin; x + margin < width; ++x) {
    const float farthest = std::max(std::max(here[x - 1], here[x + 1]), std::max(above[x], below[x]));
    mark[x] = static_cast<std::uint8_t>((here[x] < 1.0F) & (farthest >= 1.0F));
  }
}

/// Steps of a pixel along `direction` for which the silhouette stays as it is.
float reach_along(const DrawnDepth& drawn, const Eigen::Vector2d& from, const Eigen::Vector2d& direction, bool object,
                  int most) {
  for (int k = 1; k <= most; ++k) {
    const Eigen::Vector2d at = from + k * direction;
    const int x = static_cast<int>(std::lround(at.x())), y = static_cast<int>(std::lround(at.y()));
    const bool inside = x >= 0 && y >= 0 && x < drawn.rect.width && y < drawn.rect.height;
    if (!inside || is_object(drawn, x, y) != object) return static_cast<float>(k - 1);
  }
  return static_cast<float>(most);
}

}  // namespace

void contour_points(const DrawnDepth& drawn, const Camera& camera, std::size_t most, int reach, ContourScan& scan,
                    std::vector<ContourPoint>& points) {
  points.clear();
  const Rect& rect = drawn.rect;
  const auto in_picture = [&](double x, double y) {
    return x > -0.5 && y > -0.5 && x < camera.width - 0.5 && y < camera.height - 0.5;
  };
  auto& [pixels, marks] = scan;
  pixels.clear();
  marks.assign(static_cast<std::size_t>(rect.width), 0);
  for (int y = kAround; y + kAround < rect.height; ++y) {
    mark_contour(drawn, y, kAround, marks);
    const auto end = marks.end() - std::min(kAround, rect.width);
    for (auto mark = std::find(marks.begin(), end, 1); mark != end; mark = std::find(mark + 1, end, 1)) {
      const int x = static_cast<int>(mark - marks.begin());
      if (in_picture(x + rect.x, y + rect.y)) pixels.push_back({x, y});
    }
  }
  // Rows hold pixels of both sides in turn: every n-th would be of one side only.
  constexpr double kGoldenRatio = 0.6180339887498949;
  const double share = pixels.size() > most ? static_cast<double>(most) / static_cast<double>(pixels.size()) : 1;
  std::array<std::array<double, 2 * kAround + 1>, 2 * kAround + 1> weight;
  double all = 0;
  for (int v = -kAround; v <= kAround; ++v) {
    for (int u = -kAround; u <= kAround; ++u) {
      const double w = std::exp(-0.5 * (u * u + v * v) / (kSigma * kSigma));
      weight[static_cast<std::size_t>(v + kAround)][static_cast<std::size_t>(u + kAround)] = w;
      all += w;
    }
  }
  for (std::size_t i = 0; i < pixels.size() && points.size() < most; ++i) {
    const double turns = kGoldenRatio * static_cast<double>(i);
    if (turns - std::floor(turns) >= share) continue;
    const auto [x, y] = pixels[i];
    double inside = 0;
    Eigen::Vector2d towards = Eigen::Vector2d::Zero();
    for (int v = -kAround; v <= kAround; ++v) {
      for (int u = -kAround; u <= kAround; ++u) {
        if (!is_object(drawn, x + u, y + v)) continue;
        const double w = weight[static_cast<std::size_t>(v + kAround)][static_cast<std::size_t>(u + kAround)];
        inside += w;
        towards += w * Eigen::Vector2d(u, v);
      }
    }
    if (towards.norm() < 0.05 * all) continue;  // thinner than what is looked at
    const Eigen::Vector2d normal = -towards.normalized();
    const Eigen::Vector2d at = Eigen::Vector2d(x, y) + kSigma * distance_of_share(inside / all) * normal;
    ContourPoint point;
    point.normal = normal.cast<float>();
    point.inside = reach_along(drawn, at, -normal, true, reach);
    point.outside = reach_along(drawn, at, normal, false, reach);
    if (point.inside < kLeastInside) continue;
    const double z = drawn.range.metric(static_cast<double>(drawn.at(rect.x + x, rect.y + y)));
    point.p_camera =
        Eigen::Vector3d(z * (at.x() + rect.x - camera.cx) / camera.fx, z * (at.y() + rect.y - camera.cy) / camera.fy, z)
            .cast<float>();
    points.push_back(point);
  }
}

}  // namespace holdfast
