#include "init/click_session.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <set>
#include <string>

#include "holdfast/error.hpp"
#include "init/point_residuals.hpp"
#include "init/pose_from_points.hpp"

namespace holdfast::app {
namespace {

constexpr std::size_t kMostVertices = 24;    // a model of more is not asked for all
constexpr std::size_t kSpreadVertices = 14;  // but for so many
constexpr int kInset = 300;                  // pixels, drawing of the model
constexpr double kPiece = 3;                 // pixels of one colour in it
constexpr std::size_t kPairsForPose = 4;

const cv::Scalar kClickedColor(60, 60, 255);
const cv::Scalar kPreviewColor(90, 255, 120);
const cv::Scalar kAskedColor(60, 230, 255);
const cv::Scalar kTextColor(255, 255, 255);
const cv::Scalar kInsetColor(40, 38, 36);

/// Each vertex the farthest from those before.
std::vector<Eigen::Vector3d> spread_out(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& center) {
  std::vector<double> nearest(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    nearest[i] = -(points[i] - center).norm();  // so that the first is the farthest from the centre
  }
  std::vector<Eigen::Vector3d> chosen;
  auto next = std::min_element(nearest.begin(), nearest.end());
  while (chosen.size() < kSpreadVertices) {
    const Eigen::Vector3d point = points[static_cast<std::size_t>(next - nearest.begin())];
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double distance = (points[i] - point).norm();
      nearest[i] = chosen.empty() ? distance : std::min(nearest[i], distance);
    }
    chosen.push_back(point);
    next = std::max_element(nearest.begin(), nearest.end());
  }
  return chosen;
}

using Weights = Eigen::Vector3d;  // of a triangle's corners

/// Colour of a point of a triangle, BGR; grey where the model has none.
cv::Scalar color_at(const Mesh& mesh, std::size_t index, const Weights& weights) {
  const auto& triangle = mesh.triangles[index];
  const std::size_t material = mesh.triangle_materials.empty() ? 0 : mesh.triangle_materials[index];
  const bool textured = !mesh.texture_coordinates.empty() && material < mesh.materials.size() &&
                        !mesh.materials[material].texture.empty();
  if (textured) {
    const Texture& texture = mesh.materials[material].texture;
    Eigen::Vector2d uv = Eigen::Vector2d::Zero();
    for (int k = 0; k < 3; ++k) {
      uv += weights[k] * mesh.texture_coordinates[triangle[static_cast<std::size_t>(k)]].cast<double>();
    }
    const auto texel = [](double coordinate, int size) {
      const double wrapped = coordinate - std::floor(coordinate);
      return std::min(static_cast<int>(wrapped * size), size - 1);
    };
    const int column = texel(uv.x(), texture.width);
    const int row = texel(1 - uv.y(), texture.height);
    const std::uint8_t* rgba = &texture.rgba[4 * (static_cast<std::size_t>(row) * texture.width + column)];
    return {double(rgba[2]), double(rgba[1]), double(rgba[0])};
  }
  if (!mesh.colors.empty()) {
    cv::Scalar sum;
    for (int k = 0; k < 3; ++k) {
      const auto& rgba = mesh.colors[triangle[static_cast<std::size_t>(k)]];
      sum += weights[k] * cv::Scalar(rgba[2], rgba[1], rgba[0]);
    }
    return sum;
  }
  return {170, 170, 170};
}

cv::Point inset_place(const Eigen::Vector3d& p_view) {
  return {static_cast<int>(std::lround(kInset / 2.0 + p_view.x())),
          static_cast<int>(std::lround(kInset / 2.0 - p_view.y()))};
}

/// A bit of surface, small enough to be of one colour and to lie before or behind any other.
struct Piece {
  double height = 0;  // towards the viewer
  std::array<cv::Point, 3> corners;
  cv::Scalar color;
};

/// Appends the pieces of a triangle.
void cut_triangle(const Mesh& mesh, std::size_t index, const std::array<Eigen::Vector3d, 3>& corners,
                  std::vector<Piece>& pieces_of_all) {
  const Eigen::Vector3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  const double shade = normal.norm() > 0 ? 0.45 + 0.55 * std::abs(normal.z()) / normal.norm() : 1;
  const double longest =
      std::max({(corners[1] - corners[0]).norm(), (corners[2] - corners[1]).norm(), (corners[0] - corners[2]).norm()});
  const int pieces = std::clamp(static_cast<int>(std::ceil(longest / kPiece)), 1, kInset);
  const auto weights_of = [pieces](double i, double j) -> Weights {
    return {1 - (i + j) / pieces, i / pieces, j / pieces};
  };
  const auto place = [&](const Weights& w) -> Eigen::Vector3d {
    return w[0] * corners[0] + w[1] * corners[1] + w[2] * corners[2];
  };
  const auto add = [&](const Weights& a, const Weights& b, const Weights& c) {
    const Weights middle = (a + b + c) / 3;
    pieces_of_all.push_back({place(middle).z(),
                             {inset_place(place(a)), inset_place(place(b)), inset_place(place(c))},
                             color_at(mesh, index, middle) * shade});
  };
  for (int i = 0; i < pieces; ++i) {
    for (int j = 0; i + j < pieces; ++j) {
      add(weights_of(i, j), weights_of(i + 1, j), weights_of(i, j + 1));
      if (i + j + 1 < pieces) {
        add(weights_of(i + 1, j), weights_of(i + 1, j + 1), weights_of(i, j + 1));
      }
    }
  }
}

}  // namespace

std::vector<Eigen::Vector3d> vertices_to_click(const Mesh& mesh) {
  std::set<std::array<float, 3>> known;
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3f& position : mesh.positions) {
    if (known.insert({position.x(), position.y(), position.z()}).second) {
      points.push_back(position.cast<double>());
    }
  }
  return points.size() <= kMostVertices ? points : spread_out(points, mesh.center());
}

ClickSession::ClickSession(const cv::Mat& frame, const Mesh& mesh, const std::optional<Camera>& camera)
    : frame_(frame),
      mesh_(mesh),
      camera_(camera),
      enlarged_(frame),
      vertices_(vertices_to_click(mesh)),
      clicks_(vertices_.size()) {}

void ClickSession::click(const Eigen::Vector2d& place) {
  if (!all_asked()) {
    clicks_[current_++] = enlarged_.to_frame(place);
  }
}

void ClickSession::skip() {
  if (!all_asked()) {
    clicks_[current_++].reset();
  }
}

void ClickSession::back() {
  if (current_ > 0) {
    clicks_[--current_].reset();
  }
}

void ClickSession::turn_model(double yaw, double pitch) {
  yaw_ += yaw;
  pitch_ = std::clamp(pitch_ + pitch, -1.5, 1.5);
}

std::vector<PointPair> ClickSession::pairs() const {
  std::vector<PointPair> pairs;
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    if (clicks_[i]) {
      pairs.push_back({vertices_[i], *clicks_[i], fmt::format("vertex {}", i + 1)});
    }
  }
  return pairs;
}

/// Orthographic, what is far first.
void ClickSession::draw_model(cv::Mat& inset) const {
  const Eigen::Matrix3d R_view_object = (Eigen::AngleAxisd(pitch_ - M_PI / 2, Eigen::Vector3d::UnitX()) *
                                         Eigen::AngleAxisd(yaw_, Eigen::Vector3d::UnitZ()))
                                            .toRotationMatrix();
  const Eigen::Vector3d center = mesh_.center();
  const double scale = 0.4 * kInset / mesh_.radius();
  const auto view = [&](const Eigen::Vector3d& p_object) -> Eigen::Vector3d {
    return scale * (R_view_object * (p_object - center));  // x right, y up, z to the viewer
  };
  std::vector<Eigen::Vector3d> seen;
  for (const Eigen::Vector3f& position : mesh_.positions) {
    seen.push_back(view(position.cast<double>()));
  }
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh_.triangles[i];
    cut_triangle(mesh_, i, {seen[a], seen[b], seen[c]}, pieces);
  }
  std::sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) { return a.height < b.height; });
  for (const Piece& piece : pieces) {
    cv::fillConvexPoly(inset, piece.corners.data(), 3, piece.color);
  }
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    const bool asked = i == current_;
    const cv::Point at = inset_place(view(vertices_[i]));
    cv::circle(inset, at, asked ? 7 : 3,
               asked        ? kAskedColor
               : clicks_[i] ? kClickedColor
                            : kTextColor,
               asked ? cv::FILLED : 1, cv::LINE_AA);
    cv::putText(inset, fmt::format("{}", i + 1), at + cv::Point(8, -4), cv::FONT_HERSHEY_SIMPLEX, 0.4,
                asked ? kAskedColor : kTextColor, 1, cv::LINE_AA);
  }
}

void ClickSession::draw_preview(EnlargedFrame& enlarged) const {
  const std::vector<PointPair> clicked = pairs();
  if (!camera_ || clicked.size() < kPairsForPose) {
    return;
  }
  try {
    const PoseFromPoints fit = pose_from_points(clicked, *camera_);
    std::vector<PointPair> all;
    for (const Eigen::Vector3d& vertex : vertices_) {
      all.push_back({vertex, Eigen::Vector2d::Zero(), ""});
    }
    for (const Eigen::Vector2d& pixel : point_residuals(all, *camera_, fit.T_camera_object)) {
      if (pixel.allFinite()) {
        enlarged.draw_circle(pixel, kPreviewColor);
      }
    }
    enlarged.draw_text(fmt::format("green: all vertices at the pose so far, rms {:.1f} px", fit.rms), {12, 72},
                       kPreviewColor);
  } catch (const Error& error) {
    enlarged.draw_text(error.what(), {12, 72}, kClickedColor);
  }
}

cv::Mat ClickSession::picture() const {
  EnlargedFrame enlarged(frame_);
  draw_preview(enlarged);
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    if (clicks_[i]) {
      enlarged.draw_cross(*clicks_[i], kClickedColor);
      enlarged.draw_text(fmt::format("{}", i + 1), enlarged.to_picture(*clicks_[i]) + Eigen::Vector2d(8, -8),
                         kClickedColor);
    }
  }
  const std::string question =
      all_asked()
          ? "All vertices were asked for: Enter when done, b to go back"
          : fmt::format("Click vertex {} of {}, at ({:.3f}, {:.3f}, {:.3f}) m, yellow in the drawing", current_ + 1,
                        vertices_.size(), vertices_[current_].x(), vertices_[current_].y(), vertices_[current_].z());
  enlarged.draw_text(question, {12, 24}, kAskedColor);
  enlarged.draw_text("n: not seen, skip   b: back   a d w s: turn the drawing   Enter: done   Esc: give up", {12, 48},
                     kTextColor);
  cv::Mat& picture = enlarged.picture();
  if (picture.cols > kInset && picture.rows > kInset) {
    cv::Mat inset(kInset, kInset, CV_8UC3, kInsetColor);
    draw_model(inset);
    inset.copyTo(picture(cv::Rect(picture.cols - kInset, picture.rows - kInset, kInset, kInset)));
  }
  return picture;
}

}  // namespace holdfast::app
