// The lens's blur in the drawn view: against its integral in double precision, and what tracking gains by it.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "holdfast/error.hpp"
#include "holdfast/tracker.hpp"
#include "simulation/sequence.hpp"
#include "simulation/textured_box.hpp"
#include "support/ray_caster.hpp"
#include "support/render_comparison.hpp"
#include "support/simulated.hpp"

namespace {

using namespace holdfast;

/// What an image of pixels as wide as one, behind a lens of this blur, weighs at a distance.
double spread_at(double off, double sigma) {
  if (sigma == 0) return std::abs(off) < 0.5 ? 1 : 0;
  const double scale = 1 / (sigma * std::sqrt(2.0));
  return 0.5 * (std::erf((off + 0.5) * scale) - std::erf((off - 0.5) * scale));
}

/// Red of the textured surface through a lens and a pixel, summed at points an eighth of a pixel apart.
double lens_pixel(const test::RayCaster& caster, const Camera& camera, const Eigen::Vector2d& pixel, double sigma) {
  const int reach = static_cast<int>(std::ceil(8 * (0.5 + 3 * sigma)));
  double sum = 0, total = 0;
  for (int j = -reach; j < reach; ++j) {
    for (int i = -reach; i < reach; ++i) {
      const Eigen::Vector2d off((i + 0.5) / 8, (j + 0.5) / 8);
      const auto hit = caster.cast(camera, pixel + off);
      if (!hit) return std::numeric_limits<double>::quiet_NaN();  // no comparison holds then
      const double weight = spread_at(off.x(), sigma) * spread_at(off.y(), sigma);
      sum += weight * caster.color(*hit)[0];
      total += weight;
    }
  }
  return sum / total;
}

/// Root mean square of what views drawn with `drawn` pixels of blur are off where the lens has `sigma`.
double off_by(double drawn, double sigma, const Pose& T_camera_object) {
  const Camera camera{96, 80, 150, 150, 47.5, 39.5, {}};
  const Mesh mesh = test::quad(test::random_texture(40, 40, 11));
  Renderer renderer(mesh, camera.width, camera.height);
  renderer.set_lens_blur(drawn);
  const test::View view = test::draw(renderer, T_camera_object, camera);
  const test::RayCaster caster(mesh, T_camera_object);
  double sum = 0;
  int count = 0;
  for (int y = 30; y < 50; y += 3) {
    for (int x = 36; x < 60; x += 2) {
      const double expected = lens_pixel(caster, camera, Eigen::Vector2d(x, y), sigma);
      sum += std::pow(view.pixel(x, y)[0] - expected, 2);
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

}  // namespace

TEST_CASE("a view drawn with the lens's blur is nearer to what the lens shows") {
  // A texel a pixel, two thirds of one, and about as much on a slant.
  for (const Pose& T_camera_object :
       {test::pose_at({0, 0, 0.75}), test::pose_at({0, 0, 0.5}), test::pose_at({0, 0, 0.5}, {0.5, 0.4, 0.1})}) {
    for (const double sigma : {0.6, 0.9, 1.3}) {
      const double without = off_by(0, sigma, T_camera_object), with = off_by(sigma, sigma, T_camera_object);
      const double too_much = off_by(2 * sigma, sigma, T_camera_object);
      INFO("sigma ", sigma, " at ", T_camera_object.translation().z(), " m: grey levels off, rms: ", without,
           " without, ", with, " with it, ", too_much, " with twice as much");
      CHECK(with < 0.5 * without);
      CHECK(with < too_much);
    }
  }
}

TEST_CASE("a lens's blur that is none is refused") {
  const Camera camera{96, 80, 150, 150, 47.5, 39.5, {}};
  Renderer renderer(test::quad(test::random_texture(4, 4, 1)), camera.width, camera.height);
  CHECK_THROWS_AS(renderer.set_lens_blur(-0.1), Error);
  CHECK_THROWS_AS(renderer.set_lens_blur(4.1), Error);
  CHECK_THROWS_AS(renderer.set_lens_blur(std::numeric_limits<double>::quiet_NaN()), Error);
  CHECK_NOTHROW(renderer.set_lens_blur(4));
}

namespace {

/// Median errors of a tracked sequence of a printed box, millimetres, once the lens has been measured: with its blur
/// drawn and without.
std::array<double, 2> median_errors(double blur_sigma) {
  const Mesh mesh = simulation::textured_box();
  simulation::SequenceOptions options;
  options.camera = {512, 256, 685, 685, 255.5, 127.5, {}};
  options.frames = 100;
  options.seed = 107;
  options.motion.nearest = 0.8;
  options.motion.farthest = 1.0;
  options.motion.speed = 3;
  options.sensor.noise = 2;
  options.sensor.blur_sigma = blur_sigma;
  const simulation::Sequence sequence(mesh, options);
  const std::vector<cv::Mat> frames = test::frames_of(sequence);
  const auto tracked = [&](bool lens_blur) {
    TrackerOptions tracking;
    tracking.lens_blur = lens_blur;
    Tracker tracker(mesh, options.camera, tracking);
    return test::median_mm(tracker, sequence.poses(), frames, 10);
  };
  return {tracked(true), tracked(false)};
}

}  // namespace

TEST_CASE("frames of a soft lens are tracked more accurately with its blur drawn, sharp ones as without") {
  const auto [soft_with, soft_without] = median_errors(0.9);
  const auto [sharp_with, sharp_without] = median_errors(0);
  INFO("median errors, mm: soft frames ", soft_with, " with, ", soft_without, " without; sharp ", sharp_with, " with, ",
       sharp_without, " without");
  CHECK(soft_with < 0.7 * soft_without);
  CHECK(sharp_with < 1.1 * sharp_without);
}
