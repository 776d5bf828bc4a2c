// How light on an object's faces is learnt, and on which objects it is.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "imaging/shading.hpp"

using namespace holdfast;

namespace {

std::vector<LitPatch> lit(const std::vector<Eigen::Vector3d>& normals, const Eigen::Vector3d& b, double brightness) {
  std::vector<LitPatch> patches;
  for (int i = 0; i < 20; ++i) {
    for (const Eigen::Vector3d& normal : normals) patches.push_back({normal, brightness * (1 + b.dot(normal)), 60});
  }
  return patches;
}

/// A ball of triangles; of 2 rings with 4 sides, an octahedron.
Mesh ball(int rings, int sides) {
  Mesh mesh;
  for (int i = 0; i <= rings; ++i) {
    for (int j = 0; j <= sides; ++j) {
      const double a = 3.14159265 * i / rings, b = 2 * 3.14159265 * j / sides;
      mesh.positions.push_back(
          Eigen::Vector3d(std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)).cast<float>());
    }
  }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * (sides + 1) + j); };
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < sides; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

}  // namespace

TEST_CASE("three faces tell where the light comes from, whatever the exposure") {
  const std::vector<Eigen::Vector3d> normals = {Eigen::Vector3d(0.5, -0.3, -0.8).normalized(),
                                                Eigen::Vector3d(-0.7, -0.2, -0.6).normalized(),
                                                Eigen::Vector3d(0.1, -0.9, -0.4).normalized()};
  const Eigen::Vector3d b(-0.2, -0.5, -0.3);
  for (const double brightness : {0.4, 1.0, 1.7}) {
    Shading shading;
    CHECK(shading.of(normals[0]) == 1);
    for (int frame = 0; frame < 100; ++frame) shading.learn(lit(normals, b, brightness));
    // A fifth of the light may be taken for that from everywhere: what faces look like beside each other is what
    // counts.
    for (std::size_t i = 1; i < 3; ++i) {
      const double truth = (1 + b.dot(normals[i])) / (1 + b.dot(normals[0]));
      CHECK(shading.of(normals[i]) / shading.of(normals[0]) == doctest::Approx(truth).epsilon(0.01));
    }
  }
}

TEST_CASE("one face tells nothing, a few patches change nothing, and highlights hardly anything") {
  const Eigen::Vector3d front(0, 0, -1), side = Eigen::Vector3d(1, 0, -1).normalized();
  Shading shading;
  shading.learn(lit({front}, {0.3, 0, 0}, 1.3));
  CHECK(shading.direction().norm() < 1e-3);
  shading.learn(std::vector<LitPatch>{{front, 1, 60}, {side, 2, 60}});
  CHECK(shading.direction().norm() < 1e-3);

  std::vector<LitPatch> patches = lit({front, side}, {-0.3, 0, 0}, 1);
  for (int i = 0; i < 2; ++i) patches[static_cast<std::size_t>(2 * i)].brightness *= 1.6;
  for (int frame = 0; frame < 100; ++frame) shading.learn(patches);
  const double truth = (1 - 0.3 * side.x()) / 1.0;
  CHECK(shading.of(side) / shading.of(front) == doctest::Approx(truth).epsilon(0.02));
}

TEST_CASE("what the surface in view does not tell stays as it was, and a lamp that moves is followed") {
  const std::vector<Eigen::Vector3d> normals = {Eigen::Vector3d(0.5, -0.3, -0.8).normalized(),
                                                Eigen::Vector3d(-0.7, -0.2, -0.6).normalized(),
                                                Eigen::Vector3d(0.1, -0.9, -0.4).normalized()};
  const Eigen::Vector3d b(-0.2, -0.5, -0.3);
  Shading shading;
  for (int frame = 0; frame < 100; ++frame) shading.learn(lit(normals, b, 1));
  const Eigen::Vector3d before = shading.direction();
  for (int frame = 0; frame < 50; ++frame) shading.learn(lit({normals[0]}, b, 0.7));
  CHECK((shading.direction() - before).norm() < 0.01);

  const Eigen::Vector3d moved(0.3, -0.1, -0.3);
  for (int frame = 0; frame < 200; ++frame) shading.learn(lit(normals, moved, 1));
  for (std::size_t i = 1; i < 3; ++i) {
    const double truth = (1 + moved.dot(normals[i])) / (1 + moved.dot(normals[0]));
    CHECK(shading.of(normals[i]) / shading.of(normals[0]) == doctest::Approx(truth).epsilon(0.01));
  }
}

TEST_CASE("an octahedron has flat faces, a ball has none") {
  CHECK(has_flat_faces(ball(2, 4)));
  CHECK_FALSE(has_flat_faces(ball(24, 48)));
}
