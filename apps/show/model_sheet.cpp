#include "show/model_sheet.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "baking/mesh_topology.hpp"
#include "holdfast/camera.hpp"
#include "holdfast/pose.hpp"
#include "holdfast/renderer.hpp"

namespace holdfast::app {
namespace {

constexpr int kTile = 420;              // pixels a side
constexpr int kHeader = 64;             // pixels
constexpr double kFill = 0.8;           // of a tile, by the model's sphere
constexpr double kAway = 20;            // radii, so far that sides look nearly parallel
constexpr int kArrow = 34;              // pixels
constexpr double kSamplesAcross = 200;  // of the surface, along the model's box

const cv::Scalar kBackground(34, 30, 28), kText(235, 235, 235);

struct Side {
  const char* name;
  Eigen::Vector3d from;  ///< where it is looked at from
  Eigen::Vector3d up;
};

std::vector<Side> sides() {
  using Eigen::Vector3d;
  return {{"from +x", Vector3d::UnitX(), Vector3d::UnitZ()},  {"from +y", Vector3d::UnitY(), Vector3d::UnitZ()},
          {"from +z", Vector3d::UnitZ(), Vector3d::UnitY()},  {"from -x", -Vector3d::UnitX(), Vector3d::UnitZ()},
          {"from -y", -Vector3d::UnitY(), Vector3d::UnitZ()}, {"from -z", -Vector3d::UnitZ(), Vector3d::UnitY()}};
}

Eigen::AlignedBox3d box_of(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& position : mesh.positions) box.extend(position.cast<double>());
  return box;
}

/// Rows: the camera's axes in the model's.
Eigen::Matrix3d turn_of(const Side& side) {
  const Eigen::Vector3d forward = -side.from;
  Eigen::Matrix3d R;
  R.row(0) = forward.cross(side.up).transpose();
  R.row(1) = -side.up.transpose();
  R.row(2) = forward.transpose();
  return R;
}

void draw_text(cv::Mat& picture, const std::string& text, cv::Point place, double size = 0.5) {
  cv::putText(picture, text, place, cv::FONT_HERSHEY_SIMPLEX, size, kText, 1, cv::LINE_AA);
}

/// The two axes that lie across the view, and the third as a point.
void draw_axes(cv::Mat& tile, const Eigen::Matrix3d& R) {
  const std::array<cv::Scalar, 3> colors{cv::Scalar(70, 70, 240), cv::Scalar(80, 200, 80), cv::Scalar(240, 140, 60)};
  const cv::Point origin(kArrow + 22, kTile - kArrow - 22);
  for (int axis = 0; axis < 3; ++axis) {
    const cv::Point end(origin.x + static_cast<int>(std::lround(kArrow * R(0, axis))),
                        origin.y + static_cast<int>(std::lround(kArrow * R(1, axis))));
    const cv::Scalar& color = colors[static_cast<std::size_t>(axis)];
    if (end == origin) {
      cv::circle(tile, origin, 4, color, cv::FILLED, cv::LINE_AA);
      continue;
    }
    cv::arrowedLine(tile, origin, end, color, 2, cv::LINE_AA, 0, 0.25);
    const cv::Point label = origin + (end - origin) * 4 / 3 + cv::Point(-4, 4);
    cv::putText(tile, std::string(1, static_cast<char>('x' + axis)), label, cv::FONT_HERSHEY_SIMPLEX, 0.45, color, 1,
                cv::LINE_AA);
  }
}

/// Brightness of a surface by its slope, where the texture tells nothing.
double slope_light(const std::vector<double>& depth, int x, int y, double pixel) {
  const auto at = [&](int column, int row) {
    return depth[static_cast<std::size_t>(std::clamp(row, 0, kTile - 1) * kTile + std::clamp(column, 0, kTile - 1))];
  };
  const double here = at(x, y);
  const auto step = [&](double before, double after) {
    const double back = here - before, on = after - here;
    const double chosen = std::abs(back) < std::abs(on) ? back : on;
    return std::isfinite(chosen) ? chosen / pixel : 0.0;
  };
  const double across = step(at(x - 1, y), at(x + 1, y)), down = step(at(x, y - 1), at(x, y + 1));
  return 1 / std::sqrt(1 + across * across + down * down);
}

cv::Mat tile_of(Renderer& renderer, const Mesh& mesh, const Side& side) {
  const double radius = mesh.radius();
  const double focal = 0.5 * kFill * kTile * kAway;
  const double middle = 0.5 * (kTile - 1);
  const Camera camera{kTile, kTile, focal, focal, middle, middle, {}};
  Pose pose = Pose::Identity();
  pose.linear() = turn_of(side);
  pose.translation() = Eigen::Vector3d(0, 0, kAway * radius) - pose.linear() * mesh.center();
  std::vector<std::uint8_t> rgba(static_cast<std::size_t>(kTile * kTile) * 4);
  std::vector<float> window(static_cast<std::size_t>(kTile * kTile));
  const DepthRange range = renderer.render(pose, camera, {0, 0, kTile, kTile}, {rgba.data(), window.data(), kTile});
  std::vector<double> depth(window.size());
  std::transform(window.begin(), window.end(), depth.begin(),
                 [&](float d) { return d < 1 ? range.metric(d) : std::numeric_limits<double>::infinity(); });
  cv::Mat tile(kTile, kTile, CV_8UC3, kBackground);
  for (int y = 0; y < kTile; ++y) {
    for (int x = 0; x < kTile; ++x) {
      const auto place = static_cast<std::size_t>(y * kTile + x);
      if (window[place] >= 1) continue;
      const std::uint8_t* p = &rgba[4 * place];
      cv::Vec3b& pixel = tile.at<cv::Vec3b>(y, x);
      if (p[3] == 255) {
        pixel = {p[2], p[1], p[0]};
      } else {
        const auto grey = static_cast<std::uint8_t>(200 * slope_light(depth, x, y, kAway * radius / focal));
        pixel = {grey, grey, grey};
      }
    }
  }
  draw_axes(tile, pose.linear());
  draw_text(tile, side.name, {12, 22});
  return tile;
}

/// Share of a triangle whose texels are known, from `steps` samples along each side.
double known_share(const Mesh& mesh, const std::array<std::uint32_t, 3>& corners, const Texture& texture, int steps) {
  const auto texel = [](float coordinate, int size) {
    return std::clamp(static_cast<int>((coordinate - std::floor(coordinate)) * static_cast<float>(size)), 0, size - 1);
  };
  const auto& at = mesh.texture_coordinates;
  int known = 0, all = 0;
  for (int i = 0; i < steps; ++i) {
    for (int j = 0; i + j < steps; ++j, ++all) {
      const float a = (static_cast<float>(i) + 1 / 3.0F) / static_cast<float>(steps);
      const float b = (static_cast<float>(j) + 1 / 3.0F) / static_cast<float>(steps);
      const Eigen::Vector2f t = a * at[corners[0]] + b * at[corners[1]] + (1 - a - b) * at[corners[2]];
      const int x = texel(t.x(), texture.width), y = texel(1 - t.y(), texture.height);
      known += texture.rgba[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(texture.width) +
                                 static_cast<std::size_t>(x)) +
                            3] >= kKnownAlpha;
    }
  }
  return static_cast<double>(known) / all;
}

std::string size_text(const Mesh& mesh) {
  const Eigen::Vector3d size = box_of(mesh).sizes();
  const double largest = size.maxCoeff();
  const bool small = largest < 1;
  const double unit = small ? 1e3 : 1;
  return fmt::format("{:.4g} x {:.4g} x {:.4g} {} along x, y, z", size.x() * unit, size.y() * unit, size.z() * unit,
                     small ? "mm" : "m");
}

}  // namespace

cv::Mat model_sheet(const Mesh& mesh, const std::string& name, RendererChoice choice) {
  RendererOptions options;
  options.choice = choice;
  Renderer renderer(mesh, kTile, kTile, options);
  cv::Mat sheet(kHeader + 2 * kTile, 3 * kTile, CV_8UC3, kBackground);
  const std::vector<Side> all = sides();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const cv::Rect place(static_cast<int>(i % 3) * kTile, kHeader + static_cast<int>(i / 3) * kTile, kTile, kTile);
    tile_of(renderer, mesh, all[i]).copyTo(sheet(place));
  }
  draw_text(sheet, name, {12, 24}, 0.6);
  draw_text(sheet, size_text(mesh), {12, 50});
  return sheet;
}

cv::Mat with_model_sheet(const cv::Mat& picture, const Mesh& mesh, const std::string& name) {
  const cv::Mat sheet = model_sheet(mesh, name);
  cv::Mat scaled, both;
  cv::resize(sheet, scaled, {sheet.cols * picture.rows / sheet.rows, picture.rows}, 0, 0, cv::INTER_AREA);
  cv::hconcat(picture, scaled, both);
  return both;
}

std::optional<std::string> model_doubt(const Mesh& mesh) {
  const Eigen::Vector3d center = mesh.center();
  double volume = 0;  // looked at first: it takes no time
  for (const auto& triangle : mesh.triangles) {
    const auto corner = [&](std::size_t i) -> Eigen::Vector3d {
      return mesh.positions[triangle[i]].cast<double>() - center;
    };
    volume += corner(0).dot(corner(1).cross(corner(2)));
  }
  if (volume >= 0 || !baking::topology_of(mesh).inside_out) return std::nullopt;
  return "the model's faces look inwards: is it mirrored (an axis negated, or two exchanged), so that no pose fits? it "
         "does no harm if only the corners of its faces are in the wrong order ('holdfast show -o' draws it)";
}

std::string model_text(const Mesh& mesh) {
  const Eigen::AlignedBox3d box = box_of(mesh);
  const double extent = box.diagonal().norm();
  double whole = 0, known = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    const Eigen::Vector3f u = mesh.positions[b] - mesh.positions[a], v = mesh.positions[c] - mesh.positions[a];
    const double area = 0.5 * u.cross(v).cast<double>().norm();
    const std::size_t material = mesh.triangle_materials.empty() ? 0 : mesh.triangle_materials[i];
    const bool textured = material < mesh.materials.size() && !mesh.materials[material].texture.empty();
    const bool colored =
        !mesh.colors.empty() && std::min({mesh.colors[a][3], mesh.colors[b][3], mesh.colors[c][3]}) >= kKnownAlpha;
    whole += area;
    if (textured) {
      const int steps = 1 + static_cast<int>(kSamplesAcross * std::sqrt(area) / extent);
      known += area * known_share(mesh, mesh.triangles[i], mesh.materials[material].texture, steps);
    } else if (colored) {
      known += area;
    }
  }
  std::string text = fmt::format("size           {}\n", size_text(mesh));
  text +=
      fmt::format("centre         ({:.4g}, {:.4g}, {:.4g}) m\n", box.center().x(), box.center().y(), box.center().z());
  text += fmt::format("mesh           {} triangles, {} vertices\n", mesh.triangles.size(), mesh.positions.size());
  for (const Material& material : mesh.materials) {
    text += material.texture.empty() ? fmt::format("material       '{}': no texture\n", material.name)
                                     : fmt::format("material       '{}': texture of {}x{}\n", material.name,
                                                   material.texture.width, material.texture.height);
  }
  text += fmt::format("look           {:.0f} % of the surface has a known texture or colours\n",
                      100 * known / std::max(whole, 1e-300));
  return text;
}

}  // namespace holdfast::app
