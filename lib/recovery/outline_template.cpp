#include "recovery/outline_template.hpp"

#include <cmath>

#include "contour/contour_points.hpp"
#include "edges/visible_edges.hpp"

namespace holdfast {

std::vector<OutlinePoint> outline_points(const DepthView& view, const std::vector<EdgeSample>& samples,
                                         const Camera& camera, const Eigen::Vector3d& p_center, double radius,
                                         std::size_t most) {
  const Eigen::Vector2f center = camera.project(p_center).cast<float>();
  std::vector<OutlinePoint> points;
  std::vector<ContourPoint> contour;
  ContourScan scan;
  contour_points(view.drawn(), camera, most, 2, scan, contour);
  for (const ContourPoint& point : contour) {
    const Eigen::Vector2f at = camera.project(point.p_camera.cast<double>()).cast<float>() - center;
    points.push_back(
        {at.x(), at.y(), std::atan2(point.normal.y(), point.normal.x()), true, point.p_camera.cast<float>()});
  }
  std::vector<VisibleEdge> edges;
  visible_edges(samples, view.T_drawn(), camera, view.drawn(), kBehind * radius, most, edges);
  for (const VisibleEdge& edge : edges) {
    if (edge.outward != 0) continue;  // the contour has it
    const Eigen::Vector2f at = edge.pixel.cast<float>() - center, normal = edge.normal.cast<float>();
    points.push_back({at.x(), at.y(), std::atan2(normal.y(), normal.x()), false, edge.p_camera.cast<float>()});
  }
  if (points.size() <= most) return points;
  std::vector<OutlinePoint> chosen;
  for (std::size_t i = 0; i < most; ++i) chosen.push_back(points[i * points.size() / most]);
  return chosen;
}

}  // namespace holdfast
