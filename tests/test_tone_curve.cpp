// The power that tells the camera's brightness from the texture's: learnt from patches, drawn, and taken over by the
// object's pair. What tracking gains by it: test_lit_patches.cpp.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "base/levels.hpp"
#include "device/device_impl.hpp"
#include "holdfast/error.hpp"
#include "imaging/tone_curve.hpp"
#include "support/check_error.hpp"
#include "support/render_comparison.hpp"
#include "texture/photometry.hpp"

namespace {

using namespace holdfast;
using namespace holdfast::test;

/// Pixels of a curved surface whose texture varies by `contrast` (deviation of its logarithm), as a camera shows them
/// that encodes it to `power`; a share of them show something else.
class CurvedSurface {
 public:
  CurvedSurface(double power, double contrast, double hidden = 0, unsigned seed = 1)
      : power_(power), contrast_(contrast), hidden_(hidden), random_(seed) {}

  /// As LitPatches makes them of a view that is drawn to the power `drawn`.
  std::vector<LitPatch> patches(double drawn, double exposure = 1) {
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> even(0, 1);
    std::vector<LitPatch> patches;
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Vector3d n(0.4 * normal(random_), 0.4 * normal(random_), -1);
      const double texture = 0.4 * std::exp(contrast_ * normal(random_));
      double frame = exposure * std::pow(texture * shading().of(n.normalized()), power_) + 0.005 * normal(random_);
      if (even(random_) < hidden_) frame = even(random_);
      const double brightness = std::pow(std::max(0.01, frame), 1 / drawn) / texture;
      patches.push_back({n.normalized(), brightness, texture * texture, std::log(texture), texture});
    }
    return patches;
  }

  /// The light that falls on it, learnt where camera and texture agree.
  static const Shading& shading() {
    static const Shading learnt = [] {
      Shading shading;
      std::vector<LitPatch> lit;
      for (int i = 0; i < 60; ++i) {
        const Eigen::Vector3d n = Eigen::Vector3d(0.6 * std::sin(i), 0.6 * std::cos(1.7 * i), -1).normalized();
        lit.push_back({n, 1 + Eigen::Vector3d(-0.2, -0.3, -0.3).dot(n), 1});
      }
      for (int frame = 0; frame < 50; ++frame) shading.learn(lit);
      return shading;
    }();
    return learnt;
  }

 private:
  double power_, contrast_, hidden_;
  std::mt19937 random_;
};

/// The power drawn after so many frames, shading learnt beside it as the tracker does.
double learnt(CurvedSurface surface, int frames = 12) {
  ToneCurve tone;
  Shading shading;
  for (int frame = 0; frame < frames; ++frame) {
    const std::vector<LitPatch> patches = surface.patches(tone.drawn(), 0.8 + 0.05 * (frame % 5));
    shading.learn(patches);
    tone.learn(patches, shading);
  }
  return tone.drawn();
}

}  // namespace

TEST_CASE("the power is learnt beside the light, whatever the exposure, and with things in front") {
  for (const double power : {0.55, 0.7, 1.4, 1.9}) {
    CAPTURE(power);
    CHECK(learnt({power, 0.3}) == doctest::Approx(power).epsilon(0.02));
    CHECK(learnt({power, 0.3, 0.2}) == doctest::Approx(power).epsilon(0.1));
  }
}

TEST_CASE(
    "cameras that hardly differ are taken to be the same, and so are those that a plain surface shows nothing of") {
  for (const double power : {0.94, 1.0, 1.06}) CHECK(learnt({power, 0.3}) == 1);
  CHECK(learnt({1.4, 0.004}) == 1);
  ToneCurve tone;
  CurvedSurface surface(1.4, 0.3);
  std::vector<LitPatch> few = surface.patches(1);
  few.resize(5);
  tone.learn(few, CurvedSurface::shading());
  CHECK(tone.drawn() == 1);
  for (LitPatch& patch : few) patch.weight = 0;
  few.resize(20, few[0]);
  tone.learn(few, CurvedSurface::shading());
  CHECK(tone.drawn() == 1);
}

TEST_CASE("a camera that changes its curve is followed, and near the bound there is no to and fro") {
  ToneCurve tone;
  const auto watch = [&](CurvedSurface surface, int frames) {
    int changes = 0;
    for (int frame = 0; frame < frames; ++frame) {
      const bool was = tone.drawn() != 1;
      tone.learn(surface.patches(tone.drawn()), surface.shading());
      if ((tone.drawn() != 1) != was) ++changes;
    }
    return changes;
  };
  watch({1.5, 0.3}, 12);
  CHECK(tone.drawn() == doctest::Approx(1.5).epsilon(0.02));
  watch({0.75, 0.3}, 30);
  CHECK(tone.drawn() == doctest::Approx(0.75).epsilon(0.02));
  watch({1, 0.3}, 30);
  CHECK(tone.drawn() == 1);
  CHECK(watch({std::exp(0.1), 0.15, 0.3}, 200) <= 1);
}

TEST_CASE("the renderer draws to the power what it would draw, lit or not, and takes only powers in its range") {
  for (const bool textured : {false, true}) {
    const Mesh mesh = textured ? quad(random_texture(16, 16, 3)) : colored_box();
    Renderer renderer(mesh, kRenderCamera.width, kRenderCamera.height);
    const Pose pose = pose_at({0, 0, 0.5}, {0.3, 0.5, 0.1});
    for (const Eigen::Vector3d& light : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(-0.3, -0.2, -0.4)}) {
      renderer.set_shading(light);
      renderer.set_tone(1);
      const View plain = draw(renderer, pose, kRenderCamera);
      for (const double power : {0.4, 0.7, 1.4, 3.0}) {
        CAPTURE(power);
        renderer.set_tone(power);
        const View toned = draw(renderer, pose, kRenderCamera);
        REQUIRE(toned.rgba.size() == plain.rgba.size());
        double worst = 0;
        std::size_t colors = 0;
        for (std::size_t i = 0; i < plain.rgba.size(); ++i) {
          if (i % 4 == 3) {
            REQUIRE(toned.rgba[i] == plain.rgba[i]);
            continue;
          }
          // The plain view is rounded to a 255th, which the power's slope makes more or less of.
          const double low = std::pow(std::max(0.0, plain.rgba[i] - 0.5) / 255, power),
                       high = std::pow(std::min(255.0, plain.rgba[i] + 0.5) / 255, power);
          worst = std::max({worst, 255 * low - toned.rgba[i], toned.rgba[i] - 255 * high});
          if (plain.rgba[i] > 0) ++colors;
        }
        CHECK(colors > 1000);
        CHECK(worst < 0.75);
      }
    }
  }
  Renderer renderer(colored_box(), 64, 64);
  for (const double power : {0.1, 5.1, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    CHECK_ERROR(renderer.set_tone(power), ErrorCode::invalid_argument, "power", "[0.2, 5]");
  }
}

TEST_CASE("the object's pair goes on to mean the same when the view is drawn differently") {
  const Device device;
  const std::vector<Level> levels = make_levels(kRenderCamera, 2);
  Photometry photometry(device.impl(), levels, true);
  photometry.set_object_pair({{1.2, 0.9, 0.5}, {0.05, -0.02, 0.1}});
  const auto before = photometry.object_pair();
  CHECK(photometry.view_redrawn({0.4, 0.1}, {0.2, 0.16}) == doctest::Approx(0.1 / 0.16));
  const auto now = photometry.object_pair();
  for (std::size_t c = 0; c < 3; ++c) {
    for (const double deviations : {-1.0, 0.0, 2.0}) {
      const double drawn_before = 0.4 + 0.1 * deviations, drawn_now = 0.2 + 0.16 * deviations;
      CHECK(now.gain[c] * drawn_now + now.bias[c] == doctest::Approx(before.gain[c] * drawn_before + before.bias[c]));
    }
  }
  CHECK(photometry.view_redrawn({0.4, 0}, {0.2, 0.16}) == 1);
  CHECK(photometry.object_pair().gain == now.gain);
}
