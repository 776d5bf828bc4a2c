#include "simulation/rasterizer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

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

}  // namespace

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
