#include "simulation/rasterizer.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>

#include "holdfast/error.hpp"

namespace holdfast::simulation {
namespace {

constexpr double near_depth = 1e-3;  // metres: nothing nearer is drawn
constexpr int band_rows = 8;         // pixel rows drawn at a time, so that the sample buffers stay in the cache

// A linear function of the sample position.
struct Plane {
  double x = 0;
  double y = 0;
  double offset = 0;
  double at(double sample_x, double sample_y) const { return x * sample_x + y * sample_y + offset; }
};

struct Vertex {
  Eigen::Vector3d p_camera;
  Eigen::Vector3d normal;
  Eigen::Vector2d texel;
  Eigen::Vector3d color;
};

// A triangle on the sample grid. All attributes are divided by depth, which makes them linear on the screen.
struct ScreenTriangle {
  std::array<Plane, 3> edges;  // not negative inside
  Plane inverse_depth;
  std::array<Plane, 2> texel;
  std::array<Plane, 3> normal;
  std::array<Plane, 3> color;
  int first_row = 0, last_row = -1;
  int first_column = 0, last_column = -1;
  int object = 0;  // 0: the tracked one
  const MipTexture* texture = nullptr;

  bool covers(double column, double row) const {
    return std::all_of(edges.begin(), edges.end(), [&](const Plane& edge) { return edge.at(column, row) >= 0; });
  }
};

Vertex mix(const Vertex& a, const Vertex& b, double share) {
  return {a.p_camera + share * (b.p_camera - a.p_camera), a.normal + share * (b.normal - a.normal),
          a.texel + share * (b.texel - a.texel), a.color + share * (b.color - a.color)};
}

// Cuts away what lies before the near plane (Sutherland and Hodgman); a triangle becomes at most a quadrilateral.
int clip_near(const std::array<Vertex, 3>& triangle, std::array<Vertex, 4>& polygon) {
  int count = 0;
  for (int i = 0; i < 3; ++i) {
    const Vertex& from = triangle[i];
    const Vertex& to = triangle[(i + 1) % 3];
    const double from_depth = from.p_camera.z() - near_depth;
    const double to_depth = to.p_camera.z() - near_depth;
    if (from_depth >= 0) polygon[count++] = from;
    if ((from_depth >= 0) != (to_depth >= 0)) polygon[count++] = mix(from, to, from_depth / (from_depth - to_depth));
  }
  return count;
}

class TriangleSetup {
 public:
  TriangleSetup(const Camera& camera, int samples) : camera_(camera), samples_(samples) {}

  void add(const std::array<Vertex, 3>& vertices, int object, const MipTexture* texture,
           std::vector<ScreenTriangle>& triangles) const {
    std::array<Eigen::Vector2d, 3> at;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d& p = vertices[i].p_camera;
      const Eigen::Vector2d pixel(camera_.fx * p.x() / p.z() + camera_.cx, camera_.fy * p.y() / p.z() + camera_.cy);
      // Pixel centres are integers, and a pixel's samples divide its square evenly.
      at[i] = ((pixel.array() + 0.5) * samples_ - 0.5).matrix();
    }
    const Eigen::Vector2d side_1 = at[1] - at[0];
    const Eigen::Vector2d side_2 = at[2] - at[0];
    const double area = side_1.x() * side_2.y() - side_2.x() * side_1.y();
    if (!(std::abs(area) > 1e-12)) return;

    ScreenTriangle t;
    const auto bound = [](double value, int limit) { return static_cast<int>(std::clamp(value, -1.0, limit + 1.0)); };
    const int columns = camera_.width * samples_;
    const int rows = camera_.height * samples_;
    t.first_column = std::max(0, bound(std::ceil(std::min({at[0].x(), at[1].x(), at[2].x()}) - 1e-6), columns));
    t.last_column =
        std::min(columns - 1, bound(std::floor(std::max({at[0].x(), at[1].x(), at[2].x()}) + 1e-6), columns));
    t.first_row = std::max(0, bound(std::ceil(std::min({at[0].y(), at[1].y(), at[2].y()}) - 1e-6), rows));
    t.last_row = std::min(rows - 1, bound(std::floor(std::max({at[0].y(), at[1].y(), at[2].y()}) + 1e-6), rows));
    if (t.first_column > t.last_column || t.first_row > t.last_row) return;

    const auto plane = [&](double value_0, double value_1, double value_2) {
      const double d1 = value_1 - value_0;
      const double d2 = value_2 - value_0;
      Plane result;
      result.x = (d1 * side_2.y() - d2 * side_1.y()) / area;
      result.y = (d2 * side_1.x() - d1 * side_2.x()) / area;
      result.offset = value_0 - result.x * at[0].x() - result.y * at[0].y();
      return result;
    };
    t.edges = {plane(1, 0, 0), plane(0, 1, 0), plane(0, 0, 1)};
    std::array<double, 3> inverse;
    for (int i = 0; i < 3; ++i) inverse[i] = 1.0 / vertices[i].p_camera.z();
    const auto attribute = [&](auto&& value) {
      return plane(value(vertices[0]) * inverse[0], value(vertices[1]) * inverse[1], value(vertices[2]) * inverse[2]);
    };
    t.inverse_depth = attribute([](const Vertex&) { return 1.0; });
    for (int k = 0; k < 2; ++k) t.texel[k] = attribute([k](const Vertex& v) { return v.texel[k]; });
    for (int k = 0; k < 3; ++k) t.normal[k] = attribute([k](const Vertex& v) { return v.normal[k]; });
    for (int k = 0; k < 3; ++k) t.color[k] = attribute([k](const Vertex& v) { return v.color[k]; });
    t.object = object;
    t.texture = texture;
    triangles.push_back(t);
  }

 private:
  const Camera& camera_;
  int samples_;
};

std::vector<ScreenTriangle> project(const Scene& scene, const Camera& camera, int samples) {
  const TriangleSetup setup(camera, samples);
  std::vector<ScreenTriangle> triangles;
  const auto add_object = [&](const SceneObject& object, int index) {
    const Eigen::Matrix3d rotation = object.T_camera_object.linear();
    for (const DrawnMesh::Triangle& triangle : object.mesh->triangles()) {
      std::array<Vertex, 3> vertices;
      for (int i = 0; i < 3; ++i) {
        vertices[i] = {object.T_camera_object * triangle.positions[i], rotation * triangle.normals[i],
                       triangle.texels[i], triangle.colors[i].cast<double>()};
      }
      std::array<Vertex, 4> polygon;
      const int corners = clip_near(vertices, polygon);
      const MipTexture* texture =
          triangle.texture < 0 ? nullptr : &object.mesh->textures()[static_cast<std::size_t>(triangle.texture)];
      for (int i = 2; i < corners; ++i) {
        setup.add({polygon[0], polygon[i - 1], polygon[i]}, index, texture, triangles);
      }
    }
  };
  add_object(scene.object, 0);
  for (std::size_t i = 0; i < scene.occluders.size(); ++i) add_object(scene.occluders[i], static_cast<int>(i) + 1);
  return triangles;
}

// The nearest triangle of every sample in a band of rows.
class VisibilityBand {
 public:
  VisibilityBand(int first_column, int columns, int rows)
      : first_column_(first_column), columns_(columns), inverse_depth_(columns * rows), triangle_(columns * rows) {}

  void clear(int first_row, int rows) {
    first_row_ = first_row;
    rows_ = rows;
    std::fill(inverse_depth_.begin(), inverse_depth_.end(), 0.0f);
    std::fill(triangle_.begin(), triangle_.end(), -1);
  }

  void draw(const ScreenTriangle& t, int index) {
    // Neighbouring triangles share their edges' samples rather than leave gaps between them.
    constexpr double slack = 1e-9;
    const int last_row = std::min(t.last_row, first_row_ + rows_ - 1);
    for (int y = std::max(t.first_row, first_row_); y <= last_row; ++y) {
      double low = t.first_column;
      double high = t.last_column;
      bool empty = false;
      for (const Plane& edge : t.edges) {
        const double at_zero = edge.y * y + edge.offset + slack;
        if (edge.x > 0) {
          low = std::max(low, -at_zero / edge.x);
        } else if (edge.x < 0) {
          high = std::min(high, -at_zero / edge.x);
        } else if (at_zero < 0) {
          empty = true;
        }
      }
      if (empty || low > high) continue;
      const int last = static_cast<int>(std::floor(high));
      const std::size_t row = static_cast<std::size_t>(y - first_row_) * columns_;
      for (int x = static_cast<int>(std::ceil(low)); x <= last; ++x) {
        const std::size_t i = row + (x - first_column_);
        const float value = static_cast<float>(t.inverse_depth.at(x, y));
        if (value > inverse_depth_[i]) {
          inverse_depth_[i] = value;
          triangle_[i] = index;
        }
      }
    }
  }

  int triangle(int column, int row) const {
    return triangle_[static_cast<std::size_t>(row - first_row_) * columns_ + (column - first_column_)];
  }
  std::int64_t covered() const {
    return std::count_if(triangle_.begin(), triangle_.begin() + static_cast<std::ptrdiff_t>(columns_) * rows_,
                         [](int index) { return index >= 0; });
  }

 private:
  int first_column_;
  int columns_;
  int first_row_ = 0;
  int rows_ = 0;
  std::vector<float> inverse_depth_;
  std::vector<int> triangle_;
};

// What hardly changes within a pixel: how a triangle is lit there and how large a sample's footprint is on its texture.
struct Patch {
  int triangle = -1;
  Eigen::Array3f light;
  Eigen::Array3f highlight;
  MipTexture::Footprint footprint;
};

class Shader {
 public:
  Shader(const Scene& scene, const Camera& camera, int samples) : scene_(scene), camera_(camera), samples_(samples) {}

  // At a sample position, which may lie between samples.
  Patch patch(const ScreenTriangle& t, int triangle, double column, double row) const {
    Patch result;
    result.triangle = triangle;
    const double depth = 1.0 / t.inverse_depth.at(column, row);
    if (t.texture) {
      const double x = t.texel[0].at(column, row) * depth;
      const double y = t.texel[1].at(column, row) * depth;
      const auto slope = [&](double Plane::*along) {
        const double rate = t.inverse_depth.*along;
        return Eigen::Vector2f(static_cast<float>((t.texel[0].*along - x * rate) * depth),
                               static_cast<float>((t.texel[1].*along - y * rate) * depth));
      };
      result.footprint = MipTexture::footprint(slope(&Plane::x), slope(&Plane::y));
    }

    const double u = (column + 0.5) / samples_ - 0.5;
    const double v = (row + 0.5) / samples_ - 0.5;
    const Eigen::Vector3d p_camera((u - camera_.cx) / camera_.fx * depth, (v - camera_.cy) / camera_.fy * depth, depth);
    const Eigen::Vector3d to_eye = -p_camera.normalized();
    Eigen::Vector3d normal(t.normal[0].at(column, row), t.normal[1].at(column, row), t.normal[2].at(column, row));
    normal.normalize();
    if (normal.dot(to_eye) < 0) normal = -normal;  // both sides of a surface are lit

    const Finish& finish = object(t).finish;
    result.light = scene_.ambient;
    result.highlight.setZero();
    for (const PointLight& lamp : scene_.lights) {
      const Eigen::Vector3d to_light = (lamp.position - p_camera).normalized();
      const double lambert = normal.dot(to_light);
      if (lambert <= 0) continue;
      result.light += static_cast<float>(lambert) * lamp.color.array();
      if (finish.specular > 0) {
        const double half = normal.dot((to_light + to_eye).normalized());
        if (half > 0) {
          result.highlight +=
              static_cast<float>(finish.specular * std::pow(half, finish.shininess)) * lamp.color.array();
        }
      }
    }
    return result;
  }

  Eigen::Array3f shade(const ScreenTriangle& t, const Patch& patch, int column, int row) const {
    const double depth = 1.0 / t.inverse_depth.at(column, row);
    Eigen::Array3f albedo;
    if (t.texture) {
      const Eigen::Vector2d texel(t.texel[0].at(column, row) * depth, t.texel[1].at(column, row) * depth);
      albedo = t.texture->sample(texel.cast<float>(), patch.footprint, object(t).mesh->repeats());
    } else {
      for (int k = 0; k < 3; ++k) albedo[k] = static_cast<float>(t.color[k].at(column, row) * depth);
    }
    return albedo * patch.light + patch.highlight;
  }

 private:
  const SceneObject& object(const ScreenTriangle& t) const {
    return t.object == 0 ? scene_.object : scene_.occluders[static_cast<std::size_t>(t.object) - 1];
  }

  const Scene& scene_;
  const Camera& camera_;
  int samples_;
};

cv::Rect bounding_region(const std::vector<ScreenTriangle>& triangles, int samples) {
  int left = std::numeric_limits<int>::max(), top = left, right = -1, bottom = -1;
  for (const ScreenTriangle& t : triangles) {
    left = std::min(left, t.first_column / samples);
    right = std::max(right, t.last_column / samples);
    top = std::min(top, t.first_row / samples);
    bottom = std::max(bottom, t.last_row / samples);
  }
  return right < 0 ? cv::Rect() : cv::Rect(left, top, right - left + 1, bottom - top + 1);
}

std::array<std::uint16_t, 256> linear_table() {
  std::array<std::uint16_t, 256> table;
  for (std::size_t i = 0; i < table.size(); ++i) {
    table[i] = static_cast<std::uint16_t>(std::lround(65535.0 * linear_from_encoded(static_cast<double>(i) / 255.0)));
  }
  return table;
}

Eigen::Vector3f linear_color(const std::array<std::uint8_t, 4>& rgba) {
  return {static_cast<float>(linear_from_encoded(rgba[2] / 255.0)),
          static_cast<float>(linear_from_encoded(rgba[1] / 255.0)),
          static_cast<float>(linear_from_encoded(rgba[0] / 255.0))};
}

// Normals of each triangle's corners: area-weighted over the faces that meet there within the crease angle.
std::vector<std::array<Eigen::Vector3d, 3>> corner_normals(const Mesh& mesh) {
  const double crease_cosine = std::cos(40.0 * 3.14159265358979323846 / 180.0);
  std::vector<Eigen::Vector3d> face(mesh.triangles.size());
  std::map<std::array<float, 3>, std::vector<std::size_t>> faces_at;
  const auto key = [&](std::uint32_t vertex) {
    const Eigen::Vector3f& p = mesh.positions[vertex];
    return std::array<float, 3>{p.x(), p.y(), p.z()};
  };
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    const Eigen::Vector3d a = mesh.positions[t[0]].cast<double>();
    face[i] = (mesh.positions[t[1]].cast<double>() - a).cross(mesh.positions[t[2]].cast<double>() - a);
    for (const std::uint32_t vertex : t) faces_at[key(vertex)].push_back(i);
  }
  std::vector<std::array<Eigen::Vector3d, 3>> normals(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Eigen::Vector3d own = face[i].norm() > 0 ? face[i].normalized() : Eigen::Vector3d(0, 0, 1);
    for (std::size_t k = 0; k < 3; ++k) {
      Eigen::Vector3d sum = own * 1e-30;  // a face without area still has a direction
      for (const std::size_t j : faces_at[key(mesh.triangles[i][k])]) {
        if (face[j].dot(own) >= crease_cosine * face[j].norm()) sum += face[j];
      }
      normals[i][k] = sum.normalized();
    }
  }
  return normals;
}

}  // namespace

double linear_from_encoded(double value) {
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

double encoded_from_linear(double value) {
  return value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1.0 / 2.4) - 0.055;
}

MipTexture::MipTexture(const Texture& texture) {
  const std::array<std::uint16_t, 256> linear = linear_table();
  Level finest;
  finest.width = texture.width;
  finest.height = texture.height;
  finest.texels.resize(static_cast<std::size_t>(texture.width) * texture.height);
  for (std::size_t i = 0; i < finest.texels.size(); ++i) {
    const std::uint8_t* rgba = &texture.rgba[4 * i];
    finest.texels[i] = {linear[rgba[2]], linear[rgba[1]], linear[rgba[0]], 0};
  }
  levels_.push_back(std::move(finest));
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    const Level& fine = levels_.back();
    Level coarse;
    coarse.width = std::max(1, fine.width / 2);
    coarse.height = std::max(1, fine.height / 2);
    coarse.texels.resize(static_cast<std::size_t>(coarse.width) * coarse.height);
    // Sides need not be powers of two: each coarse texel averages the fine ones that its square covers.
    for (int y = 0; y < coarse.height; ++y) {
      const int y0 = y * fine.height / coarse.height;
      const int y1 = std::max(y0 + 1, (y + 1) * fine.height / coarse.height);
      for (int x = 0; x < coarse.width; ++x) {
        const int x0 = x * fine.width / coarse.width;
        const int x1 = std::max(x0 + 1, (x + 1) * fine.width / coarse.width);
        std::array<std::uint32_t, 3> sum{};
        for (int yy = y0; yy < y1; ++yy) {
          for (int xx = x0; xx < x1; ++xx) {
            const auto& texel = fine.texels[static_cast<std::size_t>(yy) * fine.width + xx];
            for (std::size_t k = 0; k < 3; ++k) sum[k] += texel[k];
          }
        }
        const std::uint32_t count = static_cast<std::uint32_t>((y1 - y0) * (x1 - x0));
        auto& texel = coarse.texels[static_cast<std::size_t>(y) * coarse.width + x];
        for (std::size_t k = 0; k < 3; ++k) texel[k] = static_cast<std::uint16_t>((sum[k] + count / 2) / count);
      }
    }
    coarse.scale_x = static_cast<float>(coarse.width) / static_cast<float>(width());
    coarse.scale_y = static_cast<float>(coarse.height) / static_cast<float>(height());
    levels_.push_back(std::move(coarse));
  }
}

Eigen::Array4f MipTexture::bilinear(const Level& level, float x, float y, bool repeat) {
  const auto floor_of = [](float value) {
    const int truncated = static_cast<int>(value);
    return truncated - (static_cast<float>(truncated) > value ? 1 : 0);
  };
  const auto place = [repeat](int index, int size) {
    if (!repeat) return std::clamp(index, 0, size - 1);
    const int rest = index % size;
    return rest < 0 ? rest + size : rest;
  };
  const int left = floor_of(x);
  const int top = floor_of(y);
  const float share_x = x - static_cast<float>(left);
  const float share_y = y - static_cast<float>(top);
  const int x0 = place(left, level.width), x1 = place(left + 1, level.width);
  const std::size_t y0 = static_cast<std::size_t>(place(top, level.height)) * level.width;
  const std::size_t y1 = static_cast<std::size_t>(place(top + 1, level.height)) * level.width;
  const auto load = [&](std::size_t i) {
    const auto& texel = level.texels[i];
    return Eigen::Array4f(texel[0], texel[1], texel[2], texel[3]);
  };
  const float right_share = share_x * (1.0f / 65535.0f);
  const float left_share = 1.0f / 65535.0f - right_share;
  const Eigen::Array4f upper = load(y0 + x0) * left_share + load(y0 + x1) * right_share;
  const Eigen::Array4f lower = load(y1 + x0) * left_share + load(y1 + x1) * right_share;
  return upper + (lower - upper) * share_y;
}

Eigen::Array4f MipTexture::trilinear(const Eigen::Vector2f& texel, float level, bool repeat) const {
  const float clamped = std::clamp(level, 0.0f, static_cast<float>(levels_.size() - 1));
  const std::size_t fine = static_cast<std::size_t>(clamped);
  const float share = clamped - static_cast<float>(fine);
  const auto at = [&](const Level& l) {
    return bilinear(l, (texel.x() + 0.5f) * l.scale_x - 0.5f, (texel.y() + 0.5f) * l.scale_y - 0.5f, repeat);
  };
  const Eigen::Array4f value = at(levels_[fine]);
  if (share < 0.01f || fine + 1 == levels_.size()) return value;
  return value + (at(levels_[fine + 1]) - value) * share;
}

MipTexture::Footprint MipTexture::footprint(const Eigen::Vector2f& across, const Eigen::Vector2f& down) {
  Footprint result;
  const Eigen::Vector2f& longer = across.squaredNorm() > down.squaredNorm() ? across : down;
  const float longest = longer.norm();
  if (longest <= 1.0f) return result;
  // The footprint's width is its area over its length: right for sheared footprints too.
  const float width = std::abs(across.x() * down.y() - across.y() * down.x()) / longest;
  // Surfaces seen at a slant are averaged along the footprint, not blurred in both directions.
  result.probes = std::clamp(static_cast<int>(std::ceil(longest / std::max(width, 0.5f) - 0.5f)), 1, 8);
  result.step = longer / static_cast<float>(result.probes);
  result.level = std::log2(std::max(longest / static_cast<float>(result.probes), 1.0f));
  return result;
}

Eigen::Array3f MipTexture::sample(const Eigen::Vector2f& texel, const Footprint& footprint, bool repeat) const {
  Eigen::Array4f sum = Eigen::Array4f::Zero();
  for (int i = 0; i < footprint.probes; ++i) {
    const float along = static_cast<float>(i) - 0.5f * static_cast<float>(footprint.probes - 1);
    sum += trilinear(texel + along * footprint.step, footprint.level, repeat);
  }
  return sum.head<3>() / static_cast<float>(footprint.probes);
}

DrawnMesh::DrawnMesh(const Mesh& mesh) {
  mesh.validate();
  std::vector<int> texture_of_material(mesh.materials.size(), -1);
  if (!mesh.texture_coordinates.empty()) {
    for (std::size_t i = 0; i < mesh.materials.size(); ++i) {
      if (mesh.materials[i].texture.empty()) continue;
      texture_of_material[i] = static_cast<int>(textures_.size());
      textures_.emplace_back(mesh.materials[i].texture);
    }
    for (const Eigen::Vector2f& uv : mesh.texture_coordinates) {
      if (uv.minCoeff() < -1e-4f || uv.maxCoeff() > 1.0f + 1e-4f) repeats_ = true;
    }
  }
  const auto normals = corner_normals(mesh);
  triangles_.resize(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    Triangle& t = triangles_[i];
    const std::size_t material = mesh.triangle_materials.empty() ? 0 : mesh.triangle_materials[i];
    t.texture = material < texture_of_material.size() ? texture_of_material[material] : -1;
    t.normals = normals[i];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = mesh.triangles[i][k];
      t.positions[k] = mesh.positions[vertex].cast<double>();
      t.texels[k].setZero();
      if (t.texture >= 0) {
        const MipTexture& texture = textures_[static_cast<std::size_t>(t.texture)];
        const Eigen::Vector2d uv = mesh.texture_coordinates[vertex].cast<double>();
        t.texels[k] = {uv.x() * texture.width() - 0.5, (1.0 - uv.y()) * texture.height() - 0.5};
      }
      t.colors[k] = mesh.colors.empty() ? Eigen::Vector3f::Constant(0.5f) : linear_color(mesh.colors[vertex]);
    }
  }
}

Layer draw(const Scene& scene, const Camera& camera, int samples, bool shade) {
  const std::vector<ScreenTriangle> triangles = project(scene, camera, samples);
  Layer layer;
  layer.region = bounding_region(triangles, samples);
  if (layer.region.empty()) return layer;
  layer.light = cv::Mat::zeros(shade ? layer.region.size() : cv::Size(), CV_32FC3);
  layer.object_share = cv::Mat::zeros(layer.region.size(), CV_32F);
  layer.other_share = cv::Mat::zeros(layer.region.size(), CV_32F);

  const Shader shader(scene, camera, samples);
  const int first_column = layer.region.x * samples;
  VisibilityBand band(first_column, layer.region.width * samples, band_rows * samples);
  const float weight = 1.0f / static_cast<float>(samples * samples);
  const int bottom = layer.region.y + layer.region.height;
  for (int top = layer.region.y; top < bottom; top += band_rows) {
    const int rows = std::min(band_rows, bottom - top);
    const int first_row = top * samples;
    const int last_row = (top + rows) * samples - 1;
    band.clear(first_row, rows * samples);
    // The object comes first in the list: what it covers before the occluders are drawn is its whole silhouette.
    bool counted = false;
    const auto count_silhouette = [&] {
      if (!counted) layer.object_samples += band.covered();
      counted = true;
    };
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      if (triangles[i].object > 0) count_silhouette();
      if (triangles[i].last_row < first_row || triangles[i].first_row > last_row) continue;
      band.draw(triangles[i], static_cast<int>(i));
    }
    count_silhouette();
    for (int y = 0; y < rows; ++y) {
      const int out_row = top + y - layer.region.y;
      float* object_share = layer.object_share.ptr<float>(out_row);
      float* other_share = layer.other_share.ptr<float>(out_row);
      for (int x = 0; x < layer.region.width; ++x) {
        Eigen::Array3f sum = Eigen::Array3f::Zero();
        Patch patch;
        int object_count = 0;
        int other_count = 0;
        for (int row = first_row + y * samples; row < first_row + (y + 1) * samples; ++row) {
          for (int column = first_column + x * samples; column < first_column + (x + 1) * samples; ++column) {
            const int index = band.triangle(column, row);
            if (index < 0) continue;
            const ScreenTriangle& t = triangles[static_cast<std::size_t>(index)];
            ++(t.object == 0 ? object_count : other_count);
            if (!shade) continue;
            if (index != patch.triangle) {
              const double middle_column = first_column + (x + 0.5) * samples - 0.5;
              const double middle_row = first_row + (y + 0.5) * samples - 0.5;
              const bool inside = t.covers(middle_column, middle_row);
              patch = shader.patch(t, index, inside ? middle_column : column, inside ? middle_row : row);
            }
            sum += shader.shade(t, patch, column, row);
          }
        }
        layer.visible_samples += object_count;
        object_share[x] = weight * static_cast<float>(object_count);
        other_share[x] = weight * static_cast<float>(other_count);
        if (shade) {
          float* light = layer.light.ptr<float>(out_row) + 3 * x;
          for (int k = 0; k < 3; ++k) light[k] = weight * sum[k];
        }
      }
    }
  }
  return layer;
}

}  // namespace holdfast::simulation
