// Surfaces of revolution, told from shapes that are nearly so; their outline answers to every motion but that turn.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "base/round_turns.hpp"
#include "support/edge_shapes.hpp"
#include "tracker/hidden_motions.hpp"

namespace {

using namespace holdfast;

Extent extent_of(const Mesh& mesh) { return {mesh.center(), mesh.radius()}; }

/// A ball as UV spheres are made: rings of facets.
Mesh ball(float radius, int rings, int facets) {
  Mesh mesh;
  for (int i = 0; i <= rings; ++i) {
    const double polar = std::numbers::pi * i / rings;
    for (int j = 0; j < facets; ++j) {
      const double turn = 2 * std::numbers::pi * j / facets;
      mesh.positions.emplace_back(radius * static_cast<float>(std::sin(polar) * std::cos(turn)),
                                  radius * static_cast<float>(std::sin(polar) * std::sin(turn)),
                                  radius * static_cast<float>(std::cos(polar)));
    }
  }
  const auto row = static_cast<std::uint32_t>(facets);
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(rings); ++i) {
    for (std::uint32_t j = 0; j < row; ++j) {
      const std::uint32_t a = i * row + j, b = i * row + (j + 1) % row;
      mesh.triangles.push_back({a, a + row, b});
      mesh.triangles.push_back({b, a + row, b + row});
    }
  }
  return mesh;
}

void place(Mesh& mesh, const Pose& T) {
  for (Eigen::Vector3f& position : mesh.positions) position = (T * position.cast<double>()).cast<float>();
}

/// Joins a block to a mesh.
void add_block(Mesh& mesh, const Eigen::Vector3f& size, const Eigen::Vector3f& at) {
  const Mesh block = test::block(size);
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Eigen::Vector3f& position : block.positions) mesh.positions.push_back(position + at);
  for (const auto& triangle : block.triangles) {
    mesh.triangles.push_back({first + triangle[0], first + triangle[1], first + triangle[2]});
  }
}

Twist any_twist(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Twist::NullaryExpr([&] { return normal(random); });
}

/// Normal equations of twenty chance rows.
NormalEquations any_equations(std::mt19937& random) {
  NormalEquations equations;
  for (int i = 0; i < 20; ++i) {
    const Twist row = any_twist(random);
    equations.A += row * row.transpose();
    equations.h += any_twist(random)(0) * row;
  }
  return equations;
}

}  // namespace

TEST_CASE("a can has one turn, about its axis wherever that is; a ball has three") {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (const int facets : {12, 24, 64}) {
    Mesh can = test::can(0.03F, 0.1F, facets);
    Pose T = Pose::Identity();
    T.linear() = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random))
                     .normalized()
                     .toRotationMatrix();
    T.translation() = Eigen::Vector3d(normal(random), normal(random), normal(random));
    place(can, T);
    const Extent extent = extent_of(can);
    const std::vector<Twist> turns = round_turns(can, extent);
    REQUIRE(turns.size() == 1);
    const Eigen::Vector3d axis = turns[0].tail<3>();
    CHECK(std::abs(axis.dot(T.linear().col(2))) == doctest::Approx(1).epsilon(1e-6));
    // A point of the axis stays where it is: its velocity is the centre's and that of the turn about the centre.
    const Eigen::Vector3d p_axis = T * Eigen::Vector3d(0, 0, 0.02);
    const Eigen::Vector3d velocity = extent.radius * turns[0].head<3>() + axis.cross(p_axis - extent.p_object_center);
    CHECK(velocity.norm() < 1e-6);
  }
  const Mesh round = ball(0.05F, 24, 48);
  CHECK(round_turns(round, extent_of(round)).size() == 3);
}

TEST_CASE("boxes, prisms of few sides, cups with a handle and bent rods are not round") {
  const auto turns_of = [](const Mesh& mesh) { return round_turns(mesh, extent_of(mesh)).size(); };
  CHECK(turns_of(test::block({0.1F, 0.1F, 0.1F})) == 0);
  CHECK(turns_of(test::block({0.1F, 0.1F, 0.3F})) == 0);
  for (const int sides : {4, 6, 8}) CHECK(turns_of(test::can(0.03F, 0.1F, sides)) == 0);
  Mesh cup = test::can(0.04F, 0.1F, 32);
  add_block(cup, {0.03F, 0.01F, 0.06F}, {0.05F, 0.0F, 0.0F});
  CHECK(turns_of(cup) == 0);
  Mesh oval = test::can(0.04F, 0.1F, 32);
  for (Eigen::Vector3f& position : oval.positions) position.x() *= 1.1F;
  CHECK(turns_of(oval) == 0);
}

TEST_CASE("equations without a turn: no answer to it, the same to every motion without its part of it") {
  std::mt19937 random(9);
  const auto any = [&] { return any_twist(random); };
  const NormalEquations outline = any_equations(random);
  Twist turn = any();
  turn.tail<3>().normalize();
  const NormalEquations left = without_turns(outline, {turn});
  CHECK((left.A * turn).norm() < 1e-9 * outline.A.norm());
  CHECK(std::abs(left.h.dot(turn)) < 1e-9 * outline.h.norm());
  CHECK((left.A - left.A.transpose()).norm() < 1e-9 * outline.A.norm());
  for (int i = 0; i < 10; ++i) {
    Twist motion = any(), other = any();
    motion.tail<3>() -= turn.tail<3>() * turn.tail<3>().dot(motion.tail<3>());
    other.tail<3>() -= turn.tail<3>() * turn.tail<3>().dot(other.tail<3>());
    CHECK(motion.dot(left.A * other) == doctest::Approx(motion.dot(outline.A * other)));
    CHECK(motion.dot(left.h) == doctest::Approx(motion.dot(outline.h)));
  }
  CHECK((without_turns(outline, {}).A - outline.A).norm() == 0);
}

TEST_CASE("a turn that texture does not show is taken from the outline's equations, other motions are not") {
  std::mt19937 random(11);
  const auto any = [&] { return any_twist(random); };
  NormalEquations outline = any_equations(random);
  Pose T_drawn = Pose::Identity();
  T_drawn.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  T_drawn.translation().z() = 0.5;
  Twist turn = Twist::Zero(), along = Twist::Zero();
  turn.tail<3>() = along.head<3>() = Eigen::Vector3d(0.6, 0, 0.8);
  const auto left = [&](const Twist& hidden, double reliability, const std::vector<Twist>& turns) {
    TextureTerms texture;
    texture.reliability = reliability;
    texture.unobservable.count = 1;
    texture.unobservable.motions.col(0) = to_camera_axes(T_drawn) * hidden;
    return without_hidden(outline, texture, T_drawn, turns);
  };
  const Twist about = turn + 0.1 * any();  // print shows it with errors
  const NormalEquations taken = left(about, 1, {turn});
  CHECK((taken.A * about).norm() < 1e-9 * outline.A.norm());
  CHECK(std::abs(taken.h.dot(about)) < 1e-9 * outline.h.norm());
  CHECK((left(along, 1, {turn}).A - outline.A).norm() == 0);
  // A ball's turns add up to one about any axis.
  Twist x = Twist::Zero(), y = Twist::Zero(), z = Twist::Zero();
  x(3) = y(4) = z(5) = 1;
  CHECK((left(x + y + z, 1, {x, y, z}).A * (x + y + z)).norm() < 1e-9 * outline.A.norm());
  CHECK((left(turn, 1, {}).A - outline.A).norm() == 0);
  CHECK((left(turn, 0.1, {turn}).A - outline.A).norm() == 0);
  outline = without_turns(outline, {turn});
  CHECK((left(turn, 1, {turn}).A - outline.A).norm() < 1e-9 * outline.A.norm());
  CHECK((left(turn, 1, {turn}).h - outline.h).norm() < 1e-9 * outline.h.norm());
}
