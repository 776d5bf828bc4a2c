// The edges that a model is said to have: of shapes where they are known, however they are cut into triangles.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <numbers>
#include <set>

#include "edges/model_edges.hpp"
#include "support/edge_shapes.hpp"

namespace {

using namespace holdfast;
using test::block;
using test::can;

std::map<int, std::vector<EdgeSample>> by_chain(const std::vector<EdgeSample>& samples) {
  std::map<int, std::vector<EdgeSample>> chains;
  for (const EdgeSample& sample : samples) chains[sample.chain].push_back(sample);
  return chains;
}

void turn(Mesh& mesh) {
  const Eigen::Matrix3f R = Eigen::AngleAxisf(0.7F, Eigen::Vector3f(1, -2, 0.5F).normalized()).toRotationMatrix();
  for (Eigen::Vector3f& position : mesh.positions) position = R * position;
}

/// Every sample lies on an edge of the block, along it, between the faces that meet there.
void check_on_block(const EdgeSample& sample, const Eigen::Vector3f& half) {
  CHECK(sample.along.norm() == doctest::Approx(1).epsilon(1e-5));
  CHECK(sample.first.norm() == doctest::Approx(1).epsilon(1e-5));
  CHECK(sample.second.norm() == doctest::Approx(1).epsilon(1e-5));
  CHECK(std::abs(sample.first.dot(sample.second)) < 1e-5F);
  CHECK(std::abs(sample.first.cross(sample.second).dot(sample.along)) == doctest::Approx(1).epsilon(1e-5));
  for (const Eigen::Vector3f& normal : {sample.first, sample.second}) {
    CHECK(normal.dot(sample.p_object) == doctest::Approx(normal.cwiseAbs().dot(half)).epsilon(1e-5));
  }
}

}  // namespace

TEST_CASE("a cube has twelve edges, evenly sampled, however its faces are cut and welded") {
  const Eigen::Vector3f half(0.05F, 0.05F, 0.05F);
  Mesh shared = block(2 * half);
  for (auto& triangle : shared.triangles) {
    for (std::uint32_t& index : triangle) {
      const auto same = std::find(shared.positions.begin(), shared.positions.end(), shared.positions[index]);
      index = static_cast<std::uint32_t>(same - shared.positions.begin());
    }
  }
  for (const Mesh& mesh : {block(2 * half), shared, block(2 * half, 7)}) {
    const std::vector<EdgeSample> samples = model_edges(mesh, 240);
    CHECK(samples.size() <= 240);
    CHECK(samples.size() > 220);
    const auto chains = by_chain(samples);
    REQUIRE(chains.size() == 12);
    std::set<std::pair<long, long>> faces;
    for (const auto& [chain, along] : chains) {
      CHECK(along.size() >= 19);
      for (std::size_t i = 0; i < along.size(); ++i) {
        check_on_block(along[i], half);
        if (i == 0) continue;
        CHECK((along[i].p_object - along[i - 1].p_object).norm() == doctest::Approx(0.005).epsilon(0.01));
        CHECK((along[i].p_object - along[i - 1].p_object).normalized().dot(along[i].along) > 0.999F);
      }
      const auto face = [](const Eigen::Vector3f& n) { return std::lround(n.dot(Eigen::Vector3f(1, 2, 3))); };
      const long a = face(along[0].first), b = face(along[0].second);
      faces.insert(std::minmax(a, b));
    }
    CHECK(faces.size() == 12);
  }
}

TEST_CASE("fewer samples than are asked for where they would lie next to each other, none without edges") {
  CHECK(model_edges(block({0.1F, 0.1F, 0.1F}), 1000000).size() < 2500);
  CHECK(model_edges(block({0.1F, 0.1F, 0.1F}), 5).size() <= 5);
  CHECK(model_edges(test::ball(0.1F), 800).empty());
}

TEST_CASE("a can has two closed rims, along whose circles their samples go") {
  constexpr float kRadius = 0.03F, kHeight = 0.1F;
  const auto chains = by_chain(model_edges(can(kRadius, kHeight, 48), 400));
  REQUIRE(chains.size() == 2);
  for (const auto& [chain, rim] : chains) {
    std::vector<double> angles;
    float side = 0;
    for (const EdgeSample& sample : rim) {
      const Eigen::Vector3f& p = sample.p_object;
      CHECK(std::abs(p.z()) == doctest::Approx(0.5 * kHeight));
      CHECK((side == 0 || side == p.z()));
      side = p.z();
      // A chord turns by up to 3.8 degrees against the circle, which the samples must not.
      const Eigen::Vector3f tangent = Eigen::Vector3f(-p.y(), p.x(), 0).normalized();
      CHECK(std::abs(sample.along.dot(tangent)) > std::cos(0.5F * 3.14159F / 180));
      const Eigen::Vector3f up(0, 0, p.z() > 0 ? 1 : -1), out = Eigen::Vector3f(p.x(), p.y(), 0).normalized();
      CHECK(std::max(sample.first.dot(up), sample.second.dot(up)) > 0.999F);
      CHECK(std::max(sample.first.dot(out), sample.second.dot(out)) > 0.99F);
      angles.push_back(std::atan2(p.y(), p.x()));
    }
    std::sort(angles.begin(), angles.end());
    const double spacing = 2 * std::numbers::pi / static_cast<double>(angles.size());
    for (std::size_t i = 0; i < angles.size(); ++i) {
      const double next = i + 1 < angles.size() ? angles[i + 1] : angles[0] + 2 * std::numbers::pi;
      CHECK(next - angles[i] < 2 * spacing);
    }
  }
}

TEST_CASE("the border of an open sheet is an edge of one face, that of two materials one of both") {
  Mesh sheet;
  test::add_face(sheet, {-0.1F, -0.1F, 0}, {0.2F, 0, 0}, {0, 0.2F, 0}, 4);
  const auto border = by_chain(model_edges(sheet, 200));
  CHECK(border.size() == 4);
  for (const auto& [chain, samples] : border) {
    for (const EdgeSample& sample : samples) {
      CHECK(sample.p_object.cwiseAbs().maxCoeff() == doctest::Approx(0.1));
      CHECK(sample.first == Eigen::Vector3f(0, 0, 1));
      CHECK(sample.second.isZero());
    }
  }
  for (const auto& triangle : sheet.triangles) {
    const float x = (sheet.positions[triangle[0]] + sheet.positions[triangle[1]] + sheet.positions[triangle[2]]).x();
    sheet.triangle_materials.push_back(x > 0 ? 1U : 0U);
  }
  const auto both = by_chain(model_edges(sheet, 200));
  CHECK(both.size() == 5);
  long between = 0;
  for (const auto& [chain, samples] : both) {
    if (samples[0].second.isZero()) continue;
    ++between;
    for (const EdgeSample& sample : samples) {
      CHECK(std::abs(sample.p_object.x()) < 1e-6F);
      CHECK(sample.second == sample.first);
    }
    CHECK(std::abs(samples.front().p_object.y() - samples.back().p_object.y()) > 0.18F);
  }
  CHECK(between == 1);
}

TEST_CASE("relief that is tiny beside the object is left out, a knob is not") {
  const std::size_t plain = by_chain(model_edges(block({0.1F, 0.1F, 0.1F}), 400)).size();
  for (const float size : {0.008F, 0.04F}) {
    CAPTURE(size);
    Mesh mesh = block({0.1F, 0.1F, 0.1F});
    const Mesh knob = block({size, size, size});
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const Eigen::Vector3f& p : knob.positions) mesh.positions.emplace_back(p + Eigen::Vector3f(0, 0, 0.05F));
    for (const auto& t : knob.triangles) mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
    CHECK(by_chain(model_edges(mesh, 400)).size() == (size < 0.01F ? plain : plain + 12));
  }
}

TEST_CASE("triangles without an area add no edge and take none away") {
  for (const bool turned : {false, true}) {
    CAPTURE(turned);
    Mesh mesh = block({0.1F, 0.1F, 0.1F}, 2);
    if (turned) turn(mesh);
    const std::vector<EdgeSample> before = model_edges(mesh, 200);
    // A corner twice, all in one place, and two edges that lie on each other.
    mesh.triangles.push_back({0, 0, 1});
    mesh.triangles.push_back({3, 3, 3});
    mesh.triangles.push_back({0, 1, 0});
    const std::vector<EdgeSample> after = model_edges(mesh, 200);
    REQUIRE(after.size() == before.size());
    for (std::size_t i = 0; i < after.size(); ++i) {
      CHECK(after[i].p_object == before[i].p_object);
      CHECK(after[i].chain == before[i].chain);
    }
  }
}

TEST_CASE("a sliver inside of a flat face is no crease") {
  for (const float width : {1e-4F, 1e-6F, 1e-8F, 0.0F}) {
    CAPTURE(width);
    // A square of four triangles about its middle, which lies next to the diagonal: one of them is next to nothing.
    Mesh sheet;
    sheet.positions = {{-0.1F, -0.1F, 0}, {0.1F, -0.1F, 0}, {0.1F, 0.1F, 0}, {-0.1F, 0.1F, 0}, {width, -width, 0}};
    sheet.triangles = {{0, 1, 4}, {1, 2, 4}, {0, 4, 2}, {0, 2, 3}};
    turn(sheet);
    CHECK(by_chain(model_edges(sheet, 200)).size() == 4);
  }
}
