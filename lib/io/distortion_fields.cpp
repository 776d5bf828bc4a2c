#include "io/distortion_fields.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/calibration_fields.hpp"

namespace holdfast::io {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

void set_distortion(Camera& camera, const std::vector<double>& d, const fs::path& path) {
  if (camera.lens == LensModel::fisheye) {
    const bool none = std::all_of(d.begin(), d.end(), [](double k) { return k == 0; });
    if (d.size() != 4 && !none) {
      fail_camera(path, fmt::format("{} distortion coefficients; a fisheye has 4: k1 k2 k3 k4", d.size()));
    }
    std::copy_n(d.begin(), std::min<std::size_t>(4, d.size()), camera.distortion.begin());
    return;
  }
  const bool known = d.empty() || d.size() == 4 || d.size() == 5 || d.size() == 8 || d.size() == 12 || d.size() == 14;
  if (!known) {
    fail_camera(path, fmt::format("{} distortion coefficients; supported are 4, 5 or 8: k1 k2 p1 p2 [k3 [k4 k5 k6]]",
                                  d.size()));
  }
  if (std::any_of(d.begin() + std::min<std::ptrdiff_t>(8, std::ssize(d)), d.end(), [](double k) { return k != 0; })) {
    fail_camera(path,
                "the thin prism and tilt terms of the distortion are not supported: calibrate with the 4, 5 or 8 "
                "coefficient model");
  }
  std::copy_n(d.begin(), std::min<std::size_t>(8, d.size()), camera.distortion.begin());
}

/// Coefficients under names of their own, k1 k2 p1 p2 k3 ..., in OpenCV's order; empty where there are none.
std::vector<double> named_coefficients(LensModel lens, const json& document, const fs::path& path) {
  constexpr std::array<std::string_view, 8> polynomial = {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  constexpr std::array<std::string_view, 4> fisheye = {"k1", "k2", "k3", "k4"};
  const std::span<const std::string_view> names =
      lens == LensModel::fisheye ? std::span<const std::string_view>(fisheye) : polynomial;
  std::vector<double> values(names.size(), 0);
  bool found = false;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (const json* value = find_field(document, {names[i]}); value != nullptr) {
      values[i] = number_of(*value, path, std::string(names[i]));
      found = true;
    }
  }
  return found ? values : std::vector<double>();
}

constexpr std::array<std::string_view, 4> kSplitNames = {"radialdistortion", "radial", "tangentialdistortion",
                                                         "tangential"};

/// MATLAB's way, radial k1 k2 [k3] and tangential p1 p2, in OpenCV's order; empty where there are none.
std::vector<double> split_coefficients(LensModel lens, const json& document, const fs::path& path) {
  const auto list = [&](std::size_t name) -> const json* {
    const json* node = find_field(document, {kSplitNames[name], kSplitNames[name + 1]});
    return node != nullptr && (node->is_structured() || node->is_number()) ? node : nullptr;  // else a switch
  };
  const json *radial = list(0), *tangential = list(2);
  if (radial == nullptr && tangential == nullptr) return {};
  const std::vector<double> k = radial != nullptr ? matrix_values(*radial, path, "radial") : std::vector<double>{0, 0};
  const std::vector<double> p =
      tangential != nullptr ? matrix_values(*tangential, path, "tangential") : std::vector<double>{0, 0};
  if (lens == LensModel::fisheye || k.size() < 2 || k.size() > 3 || p.size() != 2) {
    fail_camera(path,
                fmt::format("{} radial and {} tangential coefficients{}; supported are k1 k2 [k3] and p1 p2", k.size(),
                            p.size(), lens == LensModel::fisheye ? " of a fisheye, which has k1 k2 k3 k4" : ""));
  }
  return {k[0], k[1], p[0], p[1], k.size() > 2 ? k[2] : 0};
}

bool holds_numbers(const json& node) {
  if (node.is_structured()) return std::any_of(node.begin(), node.end(), holds_numbers);
  return node.is_number() && node.get<double>() != 0;
}

/// Calibrations whose distortion has a name that is not known are refused: without it they would be another camera's.
void require_no_other_distortion(const json& document, const json* taken, const fs::path& path) {
  for (const auto& [key, value] : document.items()) {
    const std::string name = plain_key(key);
    const bool split = name.starts_with("radial") || name.starts_with("tangential");
    if (taken == nullptr && std::ranges::any_of(kSplitNames, [&name](auto known) { return known == name; })) continue;
    const bool of_calibrating = name.starts_with("num") || name.starts_with("estimate");  // MATLAB's
    const bool meant =
        (split || name.starts_with("dist") || name.ends_with("distortion") || name.find("coef") != name.npos) &&
        !of_calibrating;
    if (meant && &value != taken && holds_numbers(value)) {
      fail_camera(
          path, fmt::format("'{}' seems to be its distortion: name it distortion_coefficients, k1 k2 p1 p2 [k3 [k4 k5 "
                            "k6]]",
                            key.substr(0, 40)));
    }
  }
}

}  // namespace

void read_distortion(Camera& camera, const json& document, const fs::path& path) {
  const json* distortion = find_field(document, {"distortioncoefficients", "distortioncoeffs", "distcoeffs",
                                                 "distcoeff", "distortion", "dist", "d", "coeffs"});
  require_no_other_distortion(document, distortion, path);
  if (distortion == nullptr || distortion->is_null()) distortion = &document;
  std::vector<double> values =
      distortion->is_object() ? named_coefficients(camera.lens, *distortion, path) : std::vector<double>();
  if (values.empty() && distortion->is_object()) values = split_coefficients(camera.lens, *distortion, path);
  if (values.empty() && distortion != &document) {
    values = matrix_values(*distortion, path, "distortion_coefficients");
  }
  if (!values.empty()) set_distortion(camera, values, path);
}

}  // namespace holdfast::io
