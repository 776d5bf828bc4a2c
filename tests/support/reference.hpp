#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

/// Obvious double-precision loops for every kernel, written from docs/math.md. They share nothing with lib/ or kernels/
/// but the meaning of the numbers.
namespace reference {

/// A value a pixel and channel; outside the image everything is zero.
struct Planes {
  int width = 0, height = 0, channels = 0;
  std::vector<double> values;
  Planes(int w, int h, int c) : width(w), height(h), channels(c), values(static_cast<std::size_t>(w * h * c)) {}
  bool inside(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
  double& at(int x, int y, int c) { return values[static_cast<std::size_t>((y * width + x) * channels + c)]; }
  double get(int x, int y, int c) const {
    return inside(x, y) ? values[static_cast<std::size_t>((y * width + x) * channels + c)] : 0.0;
  }
};

/// Two-dimensional Gaussian of premultiplied colour, divided by the coverage it met (docs/math.md, equation 6): the sum
/// over the whole window at once.
inline Planes blurred(const Planes& in, double sigma) {
  Planes out(in.width, in.height, 4);
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  double total = 0;
  for (int j = -radius; j <= radius; ++j) {
    for (int i = -radius; i <= radius; ++i) total += std::exp(-(i * i + j * j) / (2 * sigma * sigma));
  }
  for (int y = 0; y < in.height; ++y) {
    for (int x = 0; x < in.width; ++x) {
      std::array<double, 4> sum{};
      for (int j = -radius; j <= radius; ++j) {
        for (int i = -radius; i <= radius; ++i) {
          const double weight = std::exp(-(i * i + j * j) / (2 * sigma * sigma)) / total;
          for (int c = 0; c < 4; ++c) sum[static_cast<std::size_t>(c)] += weight * in.get(x + i, y + j, c);
        }
      }
      for (int c = 0; c < 3; ++c) out.at(x, y, c) = sum[3] > 1e-4 ? sum[static_cast<std::size_t>(c)] / sum[3] : 0.0;
      out.at(x, y, 3) = sum[3];
    }
  }
  return out;
}

struct Camera {
  double fx, fy, cx, cy;
};

inline double bilinear(const Planes& planes, double x, double y, int c) {
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  double sum = 0;
  for (int j = 0; j <= 1; ++j) {
    for (int i = 0; i <= 1; ++i) {
      sum += (i ? x - x0 : 1 - (x - x0)) * (j ? y - y0 : 1 - (y - y0)) * planes.get(x0 + i, y0 + j, c);
    }
  }
  return sum;
}

/// Frame values and gradients at a real position; `features` has value, d/dx, d/dy of three channels.
inline std::array<double, 9> sampled(const Planes& features, double x, double y) {
  std::array<double, 9> out{};
  for (int c = 0; c < 9; ++c) out[static_cast<std::size_t>(c)] = bilinear(features, x, y, c);
  return out;
}

/// A gain and a bias at a pixel, bilinear between cells of eight pixels; the outermost cells go on outwards.
inline double cell_value(const Planes& cells, int x, int y, int k) {
  const double px = (x - 3.5) / 8, py = (y - 3.5) / 8;
  const int x0 = static_cast<int>(std::floor(px)), y0 = static_cast<int>(std::floor(py));
  double sum = 0;
  for (int j = 0; j <= 1; ++j) {
    for (int i = 0; i <= 1; ++i) {
      const double weight = (i ? px - x0 : 1 - (px - x0)) * (j ? py - y0 : 1 - (py - y0));
      sum += weight * cells.get(std::clamp(x0 + i, 0, cells.width - 1), std::clamp(y0 + j, 0, cells.height - 1), k);
    }
  }
  return sum;
}

/// The flow constraint of one pixel and channel: how intensity r changes with the twist (v, w) of the object,
/// translation in units of `radius`, rotation about `center`; g is the gradient, intensity a pixel (equation 11).
inline Eigen::Matrix<double, 6, 1> flow_row(const Camera& camera, double x, double y, double z, double gx, double gy,
                                            const Eigen::Vector3d& center, double radius) {
  const double X = (x - camera.cx) / camera.fx * z, Y = (y - camera.cy) / camera.fy * z;
  const Eigen::Vector3d p(X, Y, z);
  // d(u, v)/dp, transposed, times the gradient.
  const Eigen::Vector3d slope(gx * camera.fx / z, gy * camera.fy / z,
                              -gx * camera.fx * X / (z * z) - gy * camera.fy * Y / (z * z));
  Eigen::Matrix<double, 6, 1> row;
  row.head<3>() = radius * slope;
  row.tail<3>() = (p - center).cross(slope);
  return row;
}

}  // namespace reference
