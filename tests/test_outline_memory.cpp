// What is remembered of an outline beside faint texture: the score to live up to, how far it is trusted, when its
// colours are learnt and forgotten; and how what is known of a pose is carried on while no texture shows it.
#include <doctest/doctest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "contour/outline_memory.hpp"
#include "solve/carried_spread.hpp"

namespace {

using namespace holdfast;

void see(OutlineMemory& memory, double score, int frames = 1) {
  for (int i = 0; i < frames; ++i) {
    memory.note_score(score);
    memory.remember_score();
  }
}

/// An outline this far from the pose that it is compared with, along x, with this information of every unknown.
OutlineEstimate outline_at(double x, double information) {
  OutlineEstimate outline;
  outline.T_camera_object.translation().x() = x;
  outline.information = information * Matrix6::Identity();
  return outline;
}

/// The excess after many frames whose outline is so many times farther off in every unknown than it says it may be.
double excess_after(double times_too_far) {
  OutlineMemory memory;
  constexpr double kInformation = 1e6;
  // All of six unknowns' error along one of them.
  const OutlineEstimate outline = outline_at(times_too_far * std::sqrt(6 / kInformation), kInformation);
  for (int i = 0; i < 400; ++i) memory.compare(outline, Pose::Identity(), Matrix6::Zero());
  return memory.excess();
}

}  // namespace

TEST_CASE("the usual score follows the frames that were held; one that was not looked at tells nothing") {
  OutlineMemory memory;
  const double ordinary = memory.expected_score();
  CHECK(memory.fits_as_usual(ordinary));
  see(memory, -1);
  CHECK(memory.expected_score() == ordinary);
  memory.note_score(0.5);
  CHECK(memory.expected_score() == ordinary);
  see(memory, 0.5, 100);
  CHECK(memory.expected_score() == doctest::Approx(0.5).epsilon(0.01));
  CHECK(memory.fits_as_usual(0.41));
  CHECK(!memory.fits_as_usual(0.39));
  memory.clear();
  CHECK(memory.expected_score() == ordinary);
}

TEST_CASE("where the first scores are surely the object's, they are usual at once") {
  OutlineMemory memory;
  memory.note_score(0.55);
  for (int i = 0; i < 3; ++i) memory.remember_score(true);
  CHECK(memory.expected_score() < 0.63);
  for (int i = 0; i < 100; ++i) memory.remember_score(true);
  memory.note_score(0.75);
  memory.remember_score(true);
  CHECK(memory.expected_score() == doctest::Approx(0.57).epsilon(0.01));
}

TEST_CASE("a score is unusually low by how scores scatter, and something in front does not become usual") {
  OutlineMemory steady, scattering;
  for (int i = 0; i < 100; ++i) {
    see(steady, i % 2 == 0 ? 0.91 : 0.89);
    see(scattering, i % 2 == 0 ? 1.0 : 0.8);
  }
  CHECK(!steady.unusually_low(0.86));
  CHECK(steady.unusually_low(0.84));
  CHECK(!scattering.unusually_low(0.75));
  CHECK(scattering.unusually_low(0.6));
  see(steady, 0.6, 3);
  CHECK(steady.unusually_low(0.7));
}

TEST_CASE("an outline that is off by more than it says is trusted less, down to what explains it, within bounds") {
  const double first = OutlineMemory().excess();
  CHECK(excess_after(4) == doctest::Approx(16).epsilon(0.02));
  CHECK(excess_after(2) == doctest::Approx(4).epsilon(0.02));
  CHECK(excess_after(100) == doctest::Approx(30));
  CHECK(excess_after(0) == doctest::Approx(1));

  OutlineMemory memory;
  const OutlineEstimate far = outline_at(1, 1e6);
  CHECK(memory.trusted_information(far).isApprox(far.information / first));
  // A single frame changes little, whatever it says.
  memory.compare(far, Pose::Identity(), Matrix6::Zero());
  CHECK(memory.excess() > first);
  CHECK(memory.excess() < 1.2 * first);
  CHECK(memory.trusted_information(far).isApprox(far.information / memory.excess()));
}

TEST_CASE("a difference as large as both covariances let expect changes nothing, a larger or smaller one does") {
  constexpr double kInformation = 1e6, kTextureVariance = 1e-3;
  const double trusted = kInformation / OutlineMemory().excess();
  // Of the distance between what texture and outline say, the share from the outline to the pose by both.
  const double share = 1 / (1 + kTextureVariance * trusted);
  const double expected = share * std::sqrt(6 * (kTextureVariance + 1 / trusted));
  for (const double times : {0.5, 1.0, 2.0}) {
    OutlineMemory memory;
    const double before = memory.excess();
    memory.compare(outline_at(times * expected, kInformation), Pose::Identity(),
                   kTextureVariance * Matrix6::Identity());
    CHECK(memory.excess() == doctest::Approx(before * std::pow(times * times, 0.1)));
  }
}

TEST_CASE("colours are learnt at once, then in every fourth frame, of a faint object in each that it fits in") {
  OutlineMemory memory;
  CHECK(!memory.learns(false, false, false));
  CHECK(memory.learns(false, false, true));
  for (int i = 0; i < 3; ++i) CHECK(!memory.learns(true, false, true));
  CHECK(memory.learns(true, false, true));
  see(memory, 0.85, 3);
  for (int i = 0; i < 3; ++i) CHECK(memory.learns(true, true, false));
  memory.note_score(0.5);
  CHECK(!memory.learns(true, true, true));
}

TEST_CASE("hidden frames do not bring the next lesson nearer") {
  OutlineMemory memory;
  REQUIRE(memory.learns(false, false, true));
  for (int i = 0; i < 10; ++i) CHECK(!memory.learns(true, false, false));
  for (int i = 0; i < 3; ++i) CHECK(!memory.learns(true, false, true));
  CHECK(memory.learns(true, false, true));
}

TEST_CASE("the usual score belongs to colours: with them it is forgotten") {
  OutlineMemory memory;
  const double ordinary = memory.expected_score();
  see(memory, 0.5, 50);
  CHECK(memory.learns(false, true, true));
  CHECK(memory.expected_score() == ordinary);
}

TEST_CASE("colours that the outline is not found by, in three frames in a row with texture in sight, are wrong") {
  OutlineMemory memory;
  const auto misses = [&](int count) {
    for (int i = 0; i < count; ++i) {
      memory.note_score(0.3);
      CHECK(!memory.mistrusts(true));
    }
  };
  misses(2);
  CHECK(memory.mistrusts(true));

  memory.clear();
  misses(2);
  memory.note_score(0.85);
  CHECK(!memory.mistrusts(true));  // found
  misses(2);
  memory.note_score(0.3);
  CHECK(!memory.mistrusts(false));  // both hidden
  misses(2);
  CHECK(memory.learns(false, true, true));  // anew
  misses(2);
}

TEST_CASE("colours not needed for thirty frames are of other surroundings") {
  OutlineMemory memory;
  for (int i = 0; i < 30; ++i) CHECK(!memory.forgets());
  CHECK(memory.forgets());
  REQUIRE(memory.learns(false, false, true));
  CHECK(!memory.forgets());
}

TEST_CASE("what is known of a pose turns with the object and fades, faster where its motion is not known") {
  CarriedSpread spread;
  CHECK(!spread.known());
  Matrix6 covariance = Matrix6::Zero();
  covariance.diagonal() << 1e-4, 4e-4, 9e-4, 1e-6, 4e-6, 9e-6;
  spread.set(Pose::Identity(), covariance);
  CHECK(spread.known());
  CHECK(spread.covariance() == covariance);

  Pose T_turned = Pose::Identity();
  T_turned.linear() = Eigen::AngleAxisd(1.5707963267948966, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  spread.carry(T_turned, true);
  Twist expected;
  expected << 4e-4, 1e-4, 9e-4, 4e-6, 1e-6, 9e-6;
  // The pose is off by so much, and its motion from a pose that was not.
  expected = 4 * expected;
  expected.array() += 1e-4;
  CHECK(spread.covariance().diagonal().isApprox(expected, 1e-9));
  // Turned by no more since.
  spread.carry(T_turned, false);
  expected.array() += 25e-4;
  CHECK(spread.covariance().diagonal().isApprox(expected, 1e-9));
  CHECK(Eigen::SelfAdjointEigenSolver<Matrix6>(spread.covariance()).eigenvalues()(0) > 0);

  spread.clear();
  CHECK(!spread.known());
}

TEST_CASE("what the last two poses were off by goes on as the object goes on") {
  constexpr double kBefore = 4e-6, kLast = 1e-6, kDrift = 1e-4;
  CarriedSpread spread;
  spread.set(Pose::Identity(), kBefore * Matrix6::Identity());
  spread.set(Pose::Identity(), kLast * Matrix6::Identity());
  for (int k = 1; k < 5; ++k) {
    spread.carry(Pose::Identity(), true);
    const double expected = (1 + k) * (1 + k) * kLast + k * k * kBefore + k * kDrift;
    CHECK(spread.covariance().isApprox(expected * Matrix6::Identity(), 1e-9));
  }
  // What shows the pose shows the motion, too.
  const double unsure = spread.covariance()(0, 0);
  spread.add(1e9 * Matrix6::Identity());
  spread.carry(Pose::Identity(), true);
  CHECK(spread.covariance()(0, 0) < 0.5 * unsure);
}

TEST_CASE("a measurement leaves unsure what it does not show") {
  CarriedSpread spread;
  spread.set(Pose::Identity(), 1e-2 * Matrix6::Identity());
  Matrix6 information = Matrix6::Zero();
  information(0, 0) = 300;
  spread.add(information);
  CHECK(spread.covariance()(0, 0) == doctest::Approx(1 / 400.0));
  for (int i = 1; i < 6; ++i) CHECK(spread.covariance()(i, i) == doctest::Approx(1e-2));
}
