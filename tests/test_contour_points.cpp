// Where a contour runs, as lines across it take it from a drawn silhouette, and which colours its two sides have.
#include <doctest/doctest.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "contour/color_histograms.hpp"
#include "contour/contour_points.hpp"

namespace {

using namespace holdfast;

constexpr int kReach = 11;

/// A picture of shapes, drawn as by a renderer: an object where a pixel's centre is in it, window depth.
class Drawing {
 public:
  Drawing(const Rect& rect, const std::function<bool(double, double)>& object) : rect_(rect) {
    for (int y = rect.y; y < rect.y + rect.height; ++y) {
      for (int x = rect.x; x < rect.x + rect.width; ++x) {
        const double window = kFar / (kFar - kNear) * (1 - kNear / z(x, y));
        depth_.push_back(object(x, y) ? static_cast<float>(window) : 1.0F);
      }
    }
  }

  /// Of the slanted plane on which the shapes lie, metres.
  static double z(double x, double y) { return 0.6 + 4e-4 * (x - 100) - 3e-4 * (y - 80); }

  std::vector<ContourPoint> points(std::size_t most = 10000, int reach = kReach) const {
    std::vector<ContourPoint> points(3);
    ContourScan scan;
    contour_points({depth_.data(), rect_, {kNear, kFar}}, camera(), most, reach, scan, points);
    return points;
  }

  static Camera camera() { return {200, 160, 230, 210, 96, 83, {}}; }

  static Eigen::Vector2d pixel(const ContourPoint& point) { return camera().project(point.p_camera.cast<double>()); }

 private:
  static constexpr double kNear = 0.4, kFar = 0.9;
  Rect rect_;
  std::vector<float> depth_;
};

double degrees_between(const ContourPoint& point, const Eigen::Vector2d& normal) {
  return std::acos(std::clamp(point.normal.cast<double>().dot(normal), -1.0, 1.0)) * 180 / std::numbers::pi;
}

const Rect kDrawn{20, 12, 160, 140};

/// Bins of two lines of 2 x 3 + 1 pixels: as seen inside, as seen outside, and other ones between them.
std::vector<int> bins_of(std::array<int, 4> inside, std::array<int, 4> outside) {
  constexpr int kBetween = 4095;
  return {inside[0], inside[1], kBetween, kBetween, kBetween, outside[0], outside[1],
          inside[2], inside[3], kBetween, kBetween, kBetween, outside[2], outside[3]};
}

}  // namespace

TEST_CASE("contour points of a disc") {
  const Eigen::Vector2d center(101.3, 78.8);
  constexpr double kRadius = 40.4;
  const Drawing drawing(kDrawn, [&](double x, double y) { return (Eigen::Vector2d(x, y) - center).norm() < kRadius; });
  const std::vector<ContourPoint> points = drawing.points();
  CHECK(points.size() > 200);
  double sum = 0, squares = 0, worst = 0, worst_angle = 0, worst_depth = 0;
  for (const ContourPoint& point : points) {
    const Eigen::Vector2d at = Drawing::pixel(point), out = at - center;
    const double off = out.norm() - kRadius;
    sum += off;
    squares += off * off;
    worst = std::max(worst, std::abs(off));
    worst_angle = std::max(worst_angle, degrees_between(point, out.normalized()));
    worst_depth = std::max(worst_depth, std::abs(static_cast<double>(point.p_camera.z()) - Drawing::z(at.x(), at.y())));
    CHECK(static_cast<double>(point.normal.norm()) == doctest::Approx(1));
    CHECK(point.inside == kReach);
    CHECK(point.outside == kReach);
  }
  const auto count = static_cast<double>(points.size());
  // Where it runs along rows or columns, its steps are longer than what is looked at around a pixel.
  CHECK(std::abs(sum / count) < 0.02);
  CHECK(std::sqrt(squares / count) < 0.14);
  CHECK(worst < 0.45);
  CHECK(worst_angle < 17);
  // The depth is that of the object's pixel, less than 1.5 pixels away.
  CHECK(worst_depth < 1.5 * std::hypot(4e-4, 3e-4));
}

TEST_CASE("contour points are at most as many as asked for") {
  const Drawing disc(kDrawn, [](double x, double y) { return std::hypot(x - 101.3, y - 78.8) < 40.4; });
  const std::size_t all = disc.points().size();
  for (const std::size_t most : {1, 2, 7, 50, 64, 100, 120, 224}) {
    CAPTURE(most);
    const std::size_t count = disc.points(most).size();
    CHECK(count <= most);
    CHECK(3 * count >= std::min(most, all));
  }
}

TEST_CASE("contour points are spread evenly along the contour") {
  const Drawing disc(kDrawn, [](double x, double y) { return std::hypot(x - 101.3, y - 78.8) < 40.4; });
  const Drawing bar(kDrawn, [](double x, double y) { return std::abs(x - 100) < 8 && std::abs(y - 80) < 60; });
  for (const std::size_t most : {50, 64, 100, 120, 160, 224}) {
    CAPTURE(most);
    std::array<double, 8> octants{};
    const std::vector<ContourPoint> points = disc.points(most);
    for (const ContourPoint& point : points) {
      const Eigen::Vector2d at = Drawing::pixel(point);
      const double turn = std::atan2(at.y() - 78.8, at.x() - 101.3) / (2 * std::numbers::pi) + 0.5;
      octants[std::min<std::size_t>(7, static_cast<std::size_t>(8 * turn))] += 1.0 / static_cast<double>(points.size());
    }
    CHECK(*std::min_element(octants.begin(), octants.end()) > 0.07);
    CHECK(*std::max_element(octants.begin(), octants.end()) < 0.18);
    double left = 0, right = 0;
    for (const ContourPoint& point : bar.points(most)) {
      left += point.normal.x() < -0.9F ? 1 : 0;
      right += point.normal.x() > 0.9F ? 1 : 0;
    }
    CHECK(left >= 0.5 * right);
    CHECK(right >= 0.5 * left);
  }
}

TEST_CASE("contour points of a slanted edge") {
  const Eigen::Vector2d middle(100.37, 80.21);
  for (const double degrees : {7.0, 20.0, 33.0, 61.0, 104.0, 200.0, 305.0}) {
    CAPTURE(degrees);
    const double angle = degrees * std::numbers::pi / 180;
    const Eigen::Vector2d normal(std::cos(angle), std::sin(angle));
    const Drawing drawing(kDrawn, [&](double x, double y) { return normal.dot(Eigen::Vector2d(x, y) - middle) < 0; });
    const std::vector<ContourPoint> points = drawing.points();
    CHECK(points.size() > 80);
    double sum = 0, squares = 0, worst_angle = 0;
    for (const ContourPoint& point : points) {
      const Eigen::Vector2d at = Drawing::pixel(point);
      const double off = normal.dot(at - middle);
      sum += off;
      squares += off * off;
      worst_angle = std::max(worst_angle, degrees_between(point, normal));
      // The object also ends where the drawing does: that is none of its contour.
      CHECK(std::min({at.x() - kDrawn.x, at.y() - kDrawn.y, kDrawn.x + kDrawn.width - 1 - at.x(),
                      kDrawn.y + kDrawn.height - 1 - at.y()}) > 2);
    }
    const auto count = static_cast<double>(points.size());
    // Steps of an edge nearly along the columns are longer than what is looked at around a pixel.
    const bool long_steps = degrees < 10;
    CHECK(std::abs(sum / count) < 0.02);
    CHECK(std::sqrt(squares / count) < (long_steps ? 0.18 : 0.1));
    CHECK(worst_angle < (long_steps ? 13 : 8));
  }
}

TEST_CASE("contour points know how far the object and the background reach") {
  const auto box = [](double x, double y, const Rect& r) {
    return x >= r.x && y >= r.y && x < r.x + r.width && y < r.y + r.height;
  };
  // Of the middle of an upright side, where no corner is near.
  const auto check_side = [](const std::vector<ContourPoint>& points, double x, double normal_x, float inside,
                             float outside) {
    CAPTURE(x);
    int count = 0;
    for (const ContourPoint& point : points) {
      const Eigen::Vector2d at = Drawing::pixel(point);
      if (std::abs(at.x() - x) > 0.4 || std::abs(at.y() - 80) > 10) continue;
      ++count;
      CHECK(degrees_between(point, {normal_x, 0}) < 3);
      // Exactly between two pixels: the last one counts or not.
      CHECK(std::abs(point.inside - (inside - 0.5F)) <= 0.5F);
      CHECK(std::abs(point.outside - (outside - 0.5F)) <= 0.5F);
    }
    CHECK(count >= 15);
  };
  for (const int width : {3, 4, 5, 8}) {
    CAPTURE(width);
    const auto points = Drawing(kDrawn, [&](double x, double y) { return box(x, y, {100, 50, width, 60}); }).points();
    check_side(points, 99.5, -1, static_cast<float>(width), kReach);
    check_side(points, 99.5 + width, 1, static_cast<float>(width), kReach);
  }
  const auto thread = Drawing(kDrawn, [&](double x, double y) { return box(x, y, {100, 50, 1, 60}); }).points();
  for (const ContourPoint& point : thread) CHECK(std::abs(Drawing::pixel(point).y() - 79.5) > 27);

  // From the left: 7 of the object, a hole of 6, more object than is looked at.
  const auto holed = Drawing(kDrawn, [&](double x, double y) {
                       return box(x, y, {70, 40, 50, 80}) && !box(x, y, {77, 60, 6, 40});
                     }).points();
  check_side(holed, 69.5, -1, 7, kReach);
  check_side(holed, 76.5, 1, 7, 6);
  check_side(holed, 82.5, -1, kReach, 6);
  check_side(holed, 119.5, 1, kReach, kReach);
  // More of the object behind a gap draws the contour of a thread beside it away from where the thread is seen.
  const auto fringed = Drawing(kDrawn, [&](double x, double y) {
                         return box(x, y, {100, 40, 1, 80}) || box(x, y, {103, 40, 50, 80});
                       }).points();
  CHECK(!fringed.empty());
  for (const ContourPoint& point : fringed) CHECK(point.inside >= 2);
  // What is not drawn is neither.
  const auto at_border = Drawing(kDrawn, [&](double x, double y) {
                           return box(x, y, {130, 40, 43, 80}) || box(x, y, {20, 40, 7, 80});
                         }).points();
  check_side(at_border, 172.5, 1, kReach, 7);
  check_side(at_border, 26.5, 1, 7, kReach);

  for (const ContourPoint& point : Drawing(kDrawn, [&](double x, double y) {
                                     return box(x, y, {70, 40, 50, 80});
                                   }).points(10000, 4)) {
    CHECK(point.inside <= 4);
    CHECK(point.outside <= 4);
  }
}

TEST_CASE("contour points where nothing, everything or a part of the picture is drawn") {
  CHECK(Drawing(kDrawn, [](double, double) { return false; }).points().empty());
  CHECK(Drawing(kDrawn, [](double, double) { return true; }).points().empty());
  CHECK(Drawing({40, 40, 5, 5}, [](double x, double y) { return x < 42 && y < 42; }).points().empty());
  CHECK(Drawing({40, 40, 0, 0}, [](double, double) { return true; }).points().empty());
  const Camera camera = Drawing::camera();
  const auto points =
      Drawing({120, 90, 120, 100}, [&](double x, double y) { return std::hypot(x - 190, y - 140) < 30; }).points();
  CHECK(points.size() > 60);
  for (const ContourPoint& point : points) {
    const Eigen::Vector2d at = Drawing::pixel(point);
    CHECK(at.x() < camera.width);
    CHECK(at.y() < camera.height);
  }
}

TEST_CASE("colours are the object's as often as they are seen on its side") {
  ColorHistograms colors;
  const auto share = [&](int bin) { return static_cast<double>(colors.share()[static_cast<std::size_t>(bin)]); };
  const auto all_even = [&] {
    return std::all_of(colors.share().begin(), colors.share().end(), [](float value) { return value == 0.5F; });
  };
  CHECK(colors.share().size() == 4096);
  CHECK(all_even());
  CHECK(!colors.known());
  colors.learn(bins_of({7, 7, 7, 8}, {9, 9, 9, 8}), 3);
  CHECK(colors.known());
  CHECK(share(7) > 0.9999);
  CHECK(share(9) < 1e-4);
  CHECK(share(8) == doctest::Approx(0.5));
  CHECK(share(1) == doctest::Approx(0.5));
  CHECK(share(4095) == doctest::Approx(0.5));

  // Known, a new frame moves frequencies a fifth of the way.
  colors.learn(bins_of({9, 9, 9, 9}, {9, 9, 9, 9}), 3);
  const double object_9 = 0.2 * 1, background_9 = 0.8 * 0.75 + 0.2 * 1;
  CHECK(share(9) == doctest::Approx(object_9 / (object_9 + background_9)).epsilon(1e-3));
  CHECK(share(7) > 0.9999);
  colors.learn(bins_of({9, 9, 9, 7}, {7, 7, 8, 8}), 3);
  const double object_7 = 0.8 * 0.8 * 0.75 + 0.2 * 0.25, background_7 = 0.2 * 0.5;
  CHECK(share(7) == doctest::Approx(object_7 / (object_7 + background_7)).epsilon(1e-3));

  colors.clear();
  CHECK(all_even());
  CHECK(!colors.known());
  // At full weight, as nothing is known any more.
  colors.learn(bins_of({5, 5, 5, 6}, {5, 6, 6, 6}), 3);
  CHECK(share(5) == doctest::Approx(0.75).epsilon(1e-3));
  CHECK(share(6) == doctest::Approx(0.25).epsilon(1e-3));
  CHECK(share(9) == doctest::Approx(0.5));
  colors.clear();
  colors.learn(bins_of({-1, -1, -1, -1}, {9, 9, 9, 9}), 3);
  CHECK(share(5) == doctest::Approx(0.5));
}

TEST_CASE("pixels that are none teach no colour") {
  ColorHistograms colors;
  const auto share = [](const ColorHistograms& of, int bin) {
    return static_cast<double>(of.share()[static_cast<std::size_t>(bin)]);
  };
  colors.learn(bins_of({7, 7, -1, 8}, {-1, -1, 8, 7}), 3);
  CHECK(share(colors, 7) == doctest::Approx((2.0 / 3) / (2.0 / 3 + 0.5)).epsilon(1e-3));
  CHECK(share(colors, 8) == doctest::Approx((1.0 / 3) / (1.0 / 3 + 0.5)).epsilon(1e-3));
  const std::vector<float> before = colors.share();
  colors.learn(bins_of({-1, -1, -1, -1}, {-1, -1, -1, -1}), 3);
  CHECK(colors.share() == before);
  CHECK(std::all_of(before.begin(), before.end(), [](float value) { return value > 0 && value < 1; }));
}
