#include "init/init_outcome.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common_options.hpp"
#include "init/point_residuals.hpp"

namespace holdfast::app {

std::string text_of(const InitOutcome& outcome, bool with_pose, const std::vector<std::filesystem::path>& written) {
  const Camera& used = outcome.from_points.camera;
  const std::vector<Eigen::Vector2d> residuals = point_residuals(outcome.from_points.pairs, used, outcome.pose());
  std::string text = fmt::format("    {:<12} {:>8} {:>8} {:>8}   {:>8} {:>8}   {:>8}\n", "point", "x m", "y m", "z m",
                                 "u px", "v px", "off px");
  for (std::size_t i = 0; i < outcome.from_points.pairs.size(); ++i) {
    const PointPair& pair = outcome.from_points.pairs[i];
    text += fmt::format("{:>3} {:<12} {:>8.4f} {:>8.4f} {:>8.4f}   {:>8.1f} {:>8.1f}   {:>8.2f}\n", i + 1, pair.name,
                        pair.p_object.x(), pair.p_object.y(), pair.p_object.z(), pair.pixel.x(), pair.pixel.y(),
                        residuals[i].norm());
  }
  text += fmt::format("rms            {:.2f} px over {} points\n", root_mean_square(residuals),
                      outcome.from_points.pairs.size());
  if (!outcome.refinement || !outcome.refinement->accepted) {
    text += fmt::format("deviation      {:.1f} mm, {:.2f} degrees, of the pose that the points give\n",
                        1e3 * outcome.from_points.position_sigma, outcome.from_points.rotation_sigma * 180 / M_PI);
  }
  if (!outcome.off_surface.empty()) {
    text += fmt::format("off the model  {:.2f} mm at most\n",
                        1e3 * *std::max_element(outcome.off_surface.begin(), outcome.off_surface.end()));
  }
  if (outcome.focal_estimated) {
    text += fmt::format("focal length   {:.1f} +- {:.0f} px, centre ({:.1f}, {:.1f})\n", used.fx,
                        outcome.from_points.focal_sigma, used.cx, used.cy);
  }
  if (outcome.refinement && outcome.refinement->accepted) {
    text += fmt::format("refined        on the frame: moved {:.2f} px, correlation {:.3f}\n", outcome.refinement->moved,
                        outcome.refinement->correlation);
  }
  const Eigen::Vector3d& t = outcome.pose().translation();
  text +=
      fmt::format("object at      ({:.4f}, {:.4f}, {:.4f}) m: right, down, ahead of the camera\n", t.x(), t.y(), t.z());
  if (with_pose) {
    const auto& matrix = outcome.pose().matrix();
    for (int row = 0; row < 4; ++row) {
      text +=
          fmt::format("{:.9g} {:.9g} {:.9g} {:.9g}\n", matrix(row, 0), matrix(row, 1), matrix(row, 2), matrix(row, 3));
    }
  }
  for (const std::filesystem::path& path : written) {
    text += fmt::format("written        {}\n", path.string());
  }
  return text;
}

std::string json_of(const InitOutcome& outcome) {
  using Json = nlohmann::ordered_json;
  const Camera& used = outcome.from_points.camera;
  const std::vector<Eigen::Vector2d> residuals = point_residuals(outcome.from_points.pairs, used, outcome.pose());
  Json document;
  Json rows = Json::array();
  for (int row = 0; row < 4; ++row) {
    const auto values = outcome.pose().matrix().row(row);
    rows.push_back({values(0), values(1), values(2), values(3)});
  }
  document["T_camera_object"] = rows;
  document["camera"] = {{"width", used.width},
                        {"height", used.height},
                        {"fx", used.fx},
                        {"fy", used.fy},
                        {"cx", used.cx},
                        {"cy", used.cy},
                        {"lens", lens_name(used.lens)},
                        {"distortion", used.distortion}};
  document["focal_sigma_px"] = outcome.focal_estimated ? Json(outcome.from_points.focal_sigma) : Json(nullptr);
  document["rms_px"] = root_mean_square(residuals);
  document["points"] = Json::array();
  for (std::size_t i = 0; i < outcome.from_points.pairs.size(); ++i) {
    const PointPair& pair = outcome.from_points.pairs[i];
    document["points"].push_back({{"name", pair.name},
                                  {"p_object", {pair.p_object.x(), pair.p_object.y(), pair.p_object.z()}},
                                  {"pixel", {pair.pixel.x(), pair.pixel.y()}},
                                  {"residual_px", {residuals[i].x(), residuals[i].y()}}});
  }
  document["off_surface_m"] = outcome.off_surface.empty() ? Json(nullptr) : Json(outcome.off_surface);
  document["refinement"] = nullptr;
  if (outcome.refinement) {
    document["refinement"] = {{"accepted", outcome.refinement->accepted},
                              {"reason", outcome.refinement->reason},
                              {"correlation", outcome.refinement->correlation},
                              {"moved_px", outcome.refinement->moved}};
  }
  document["warnings"] = outcome.from_points.warnings;
  return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace holdfast::app
