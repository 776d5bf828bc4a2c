// Which of a model's edges are seen, and how they lie in the picture: against rays cast through it.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <vector>

#include "edges/visible_edges.hpp"
#include "support/edge_shapes.hpp"
#include "support/ray_caster.hpp"
#include "support/render_comparison.hpp"

namespace {

using namespace holdfast;

const Camera kCamera{323, 241, 402, 391, 160.3, 118.7, {}};
constexpr double kTolerance = 0.004;

/// A plate, and a block that floats before one half of it.
Mesh plate_and_block() {
  Mesh mesh = test::block({0.24F, 0.16F, 0.02F});
  const Mesh before = test::block({0.09F, 0.1F, 0.04F});
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Eigen::Vector3f& p : before.positions) mesh.positions.emplace_back(p + Eigen::Vector3f(0.09F, 0, -0.08F));
  for (const auto& t : before.triangles) mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  return mesh;
}

struct Seen {
  Seen(const Mesh& its_mesh, const Pose& pose, std::size_t most = 10000)
      : mesh(its_mesh), T(pose), samples(model_edges(mesh, 600)) {
    Renderer renderer(mesh, kCamera.width, kCamera.height);
    const test::View view = test::draw(renderer, T, kCamera);
    visible_edges(samples, T, kCamera, {view.window_depth.data(), view.roi, view.range}, kTolerance, most, visible);
  }

  Mesh mesh;
  Pose T;
  std::vector<EdgeSample> samples;
  std::vector<VisibleEdge> visible;
};

std::array<Pose, 4> poses() {
  return {test::pose_at({0, 0, 0.45}, {0.35, 0.4, 0.1}), test::pose_at({0.01, -0.01, 0.5}, {-0.5, -0.6, 0.8}),
          test::pose_at({0, 0.02, 0.45}, {0.1, 2.9, 0.3}), test::pose_at({-0.02, 0, 0.5}, {1.3, 0.3, -0.4})};
}

/// What rays say of a point of the surface: does anything lie before it?
enum class Sight { clear, unsure, hidden };

Sight sight_of(const test::RayCaster& caster, const Eigen::Vector3d& p_camera) {
  long before = 0, rays = 0;
  for (const double radius : {0.0, 1.0, 2.0, 3.0}) {
    for (int k = 0; k < 12; ++k, ++rays) {
      const double angle = k * std::numbers::pi / 6;
      const auto hit =
          caster.cast(kCamera, kCamera.project(p_camera) + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
      if (hit && hit->depth < p_camera.z() - 2 * kTolerance) ++before;
    }
  }
  return before == 0 ? Sight::clear : before == rays ? Sight::hidden : Sight::unsure;
}

bool in_picture(const Eigen::Vector2d& pixel, double margin) {
  return pixel.x() > margin && pixel.y() > margin && pixel.x() < kCamera.width - 1 - margin &&
         pixel.y() < kCamera.height - 1 - margin;
}

}  // namespace

TEST_CASE("what rays reach is seen, what they do not is not, and edges turned away are not") {
  const Mesh mesh = plate_and_block();
  long clear = 0, hidden = 0;
  for (const Pose& T : poses()) {
    const Seen seen(mesh, T);
    const test::RayCaster caster(mesh, T);
    std::map<int, const VisibleEdge*> found;
    for (const VisibleEdge& edge : seen.visible) found[edge.sample] = &edge;
    for (std::size_t i = 0; i < seen.samples.size(); ++i) {
      CAPTURE(i);
      const EdgeSample& sample = seen.samples[i];
      const Eigen::Vector3d p_camera = T * sample.p_object.cast<double>();
      // A block's face is seen where the eye is before its plane.
      const Eigen::Vector3f eye = (T.inverse() * Eigen::Vector3d::Zero()).cast<float>();
      const bool first = sample.first.dot(eye - sample.p_object) > 0,
                 second = sample.second.dot(eye - sample.p_object) > 0;
      const auto at = found.find(static_cast<int>(i));
      if (at != found.end()) {
        CHECK(at->second->faces == (first ? 1 : 0) + (second ? 2 : 0));
        CHECK((at->second->p_camera - p_camera).norm() < 1e-6);
      }
      if (!first && !second) {
        CHECK(at == found.end());
        continue;
      }
      const Sight sight = sight_of(caster, p_camera);
      if (sight == Sight::hidden) {
        ++hidden;
        CHECK(at == found.end());
      } else if (sight == Sight::clear && in_picture(kCamera.project(p_camera), 3)) {
        // A neighbour may stand for it.
        const bool stood_for = std::any_of(seen.visible.begin(), seen.visible.end(), [&](const VisibleEdge& edge) {
          return seen.samples[static_cast<std::size_t>(edge.sample)].chain == sample.chain &&
                 (edge.pixel - kCamera.project(p_camera)).norm() < 1.5;
        });
        ++clear;
        CHECK((at != found.end() || stood_for));
      }
    }
  }
  CHECK(clear > 600);
  CHECK(hidden > 30);
}

TEST_CASE("a line lies at its sample, across the edge, and knows on which side the object ends") {
  const Mesh mesh = plate_and_block();
  long ends = 0, goes_on = 0;
  for (const Pose& T : poses()) {
    const Seen seen(mesh, T);
    const test::RayCaster caster(mesh, T);
    for (const VisibleEdge& edge : seen.visible) {
      CAPTURE(edge.sample);
      const EdgeSample& sample = seen.samples[static_cast<std::size_t>(edge.sample)];
      CHECK((edge.pixel - kCamera.project(T * sample.p_object.cast<double>())).norm() < 1e-6);
      CHECK(edge.normal.norm() == doctest::Approx(1));
      const Eigen::Vector2d along =
          kCamera.project(T * (sample.p_object + 1e-3F * sample.along).cast<double>()) - edge.pixel;
      CHECK(std::abs(edge.normal.dot(along)) < 0.02 * along.norm());
      CHECK(along.x() * edge.normal.y() - along.y() * edge.normal.x() > 0);
      // Does the surface go on where the line does? Where rays to both sides of a pixel or two agree.
      const auto falls_off = [&](double side) -> std::optional<bool> {
        std::optional<bool> answer;
        for (const double pixels : {0.7, 1.5, 2.3}) {
          const auto hit = caster.cast(kCamera, edge.pixel + side * pixels * edge.normal);
          const bool off = !hit || hit->depth > edge.p_camera.z() + 4 * kTolerance;
          if (!off && hit->depth > edge.p_camera.z() + 2 * kTolerance) return {};
          if (answer && *answer != off) return {};
          answer = off;
        }
        return answer;
      };
      const std::optional<bool> left = falls_off(1), right = falls_off(-1);
      if (!left || !right) continue;
      CHECK(edge.outward == (*left ? 1 : 0) - (*right ? 1 : 0));
      ++(edge.outward != 0 ? ends : goes_on);
    }
  }
  CHECK(ends > 300);
  CHECK(goes_on > 150);
}

TEST_CASE(
    "lines of a chain lie apart, none outside of the picture, and of too many every part of the object keeps some") {
  const Mesh mesh = test::block({0.2F, 0.14F, 0.1F});
  for (const double x : {0.0, 0.2, 0.6}) {
    CAPTURE(x);
    const Seen seen(mesh, test::pose_at({x, 0.05, 0.5}, {0.4, 0.5, 0.2}));
    for (std::size_t i = 0; i < seen.visible.size(); ++i) {
      CHECK(in_picture(seen.visible[i].pixel, 0));
      if (i == 0) continue;
      const auto chain = [&](std::size_t n) {
        return seen.samples[static_cast<std::size_t>(seen.visible[n].sample)].chain;
      };
      CHECK(seen.visible[i].sample > seen.visible[i - 1].sample);
      if (chain(i) == chain(i - 1)) CHECK((seen.visible[i].pixel - seen.visible[i - 1].pixel).norm() >= 1.5);
    }
    CHECK((seen.visible.empty()) == (x > 0.5));
  }
  CHECK(Seen(mesh, test::pose_at({0, 0, -0.5})).visible.empty());

  const Pose T = test::pose_at({0, 0, 0.5}, {0.4, 0.5, 0.2});
  const Seen all(mesh, T), some(mesh, T, 50);
  REQUIRE(all.visible.size() > 150);
  REQUIRE(some.visible.size() == 50);
  const double share = 50.0 / static_cast<double>(all.visible.size());
  std::map<int, std::array<double, 2>> counts;
  for (const VisibleEdge& edge : all.visible) ++counts[all.samples[static_cast<std::size_t>(edge.sample)].chain][0];
  for (const VisibleEdge& edge : some.visible) ++counts[some.samples[static_cast<std::size_t>(edge.sample)].chain][1];
  CHECK(counts.size() == 9);
  for (const auto& [chain, count] : counts) CHECK(std::abs(count[1] - share * count[0]) <= 1);
}
