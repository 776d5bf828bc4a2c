// Textures completed from tracked frames: what is taken, what is not, and a model that grows while it is followed.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "baking/model_completion.hpp"
#include "baking/texture_baker.hpp"
#include "simulation/sequence.hpp"
#include "simulation/textured_box.hpp"
#include "support/painted_object.hpp"
#include "support/simulated.hpp"

using namespace holdfast;
using namespace holdfast::baking;
using namespace holdfast::test;

namespace {

/// Turns by `angle`; the face y- comes into view.
Pose turned(double angle) { return look(0.25 + angle, 0.55); }

/// Texels of the face that turns in, as they are now.
struct NewFace {
  long known = 0;
  long wrong = 0;  // of these, off by more than 8 levels
};

NewFace new_face(const TextureBaker& baker, double tolerance = 8) {
  NewFace face;
  for (const Texel& texel : surface_texels(baker.model())) {
    if (texel.normal.y() < -0.9 && texel.rgba[3] != 0) {
      ++face.known;
      face.wrong += error_of_texel(texel) > tolerance ? 1 : 0;
    }
  }
  return face;
}

TextureBaker started(const Mesh& shape) {
  TextureBaker baker = make_baker(shape, kPhotoCamera, turned(-0.4), texture_options(), {});
  baker.add_frame(photograph(shape, kPhotoCamera, turned(-0.4)), turned(-0.4), PoseSource::given);
  REQUIRE(new_face(baker).known == 0);
  return baker;
}

}  // namespace

TEST_CASE("Tracked frames never touch what a given pose brought; right after it they even out its noise") {
  const Mesh shape = one_box();
  const Pose first = look(0.5, 0.6);
  cv::Mat noise(kPhotoCamera.height, kPhotoCamera.width, CV_16SC3);
  cv::RNG random(5);
  const auto noisy = [&](const Pose& pose) {
    random.fill(noise, cv::RNG::NORMAL, 0, 6);
    cv::Mat frame = photograph(shape, kPhotoCamera, pose);
    cv::add(frame, noise, frame, cv::noArray(), CV_8UC3);
    return frame;
  };
  TextureBaker baker = make_baker(shape, kPhotoCamera, first, texture_options(), {});
  baker.add_frame(noisy(first), first, PoseSource::given);
  const Mesh before = baker.model();
  const auto rms = [](const Mesh& baked, const Mesh& known) {
    double sum = 0;
    double count = 0;
    const std::vector<Texel> of = surface_texels(known);
    const std::vector<Texel> now = surface_texels(baked);
    for (std::size_t i = 0; i < of.size(); ++i) {
      if (of[i].rgba[3] != 0) {
        sum += std::pow(error_of_texel(now[i]), 2);
        ++count;
      }
    }
    return std::sqrt(sum / count);
  };
  PoseSource source = PoseSource::tracked;
  SUBCASE("tracked") {}
  SUBCASE("opening") { source = PoseSource::opening; }
  for (int i = 1; i <= 12; ++i) {
    // Nearer, so that the view is better, and tracked with an error of 2 mm sideways (1.5 px).
    const Pose truth = look(0.5 + 0.01 * i, 0.6, {0.01, -0.005, 0.42 - 0.012 * i});
    Pose tracked = truth;
    if (source == PoseSource::tracked) {
      tracked.translation().x() += 0.002;
    }
    CHECK(baker.add_frame(noisy(truth), tracked, source).taken);
  }
  const Mesh after = baker.model();
  const Texture& texture_before = before.materials[0].texture;
  const Texture& texture_after = after.materials[0].texture;
  if (source == PoseSource::tracked) {
    long changed = 0;
    for (std::size_t i = 0; i < texture_before.rgba.size(); i += 4) {
      changed += texture_before.rgba[i + 3] == 255 &&
                         !std::equal(&texture_before.rgba[i], &texture_before.rgba[i] + 4, &texture_after.rgba[i])
                     ? 1
                     : 0;
    }
    CHECK(changed == 0);
  } else {
    CHECK(rms(before, before) > 5.0);  // the largest of three channels' errors
    CHECK(rms(after, before) < 0.55 * rms(before, before));
  }
}

TEST_CASE("What turns into view is taken once two frames between which the object moved agree") {
  const Mesh shape = one_box();
  TextureBaker baker = started(shape);
  const auto add = [&](double angle) {
    return baker.add_frame(photograph(shape, kPhotoCamera, turned(angle)), turned(angle), PoseSource::tracked);
  };
  CHECK(add(0.4).taken);
  CHECK(new_face(baker).known == 0);
  CHECK(add(0.402).taken);  // 0.2 px: the same view
  CHECK(new_face(baker).known == 0);
  CHECK(add(0.45).new_texels > 1000);
  const NewFace face = new_face(baker);
  CHECK(face.known > 1000);
  CHECK(face.wrong == 0);
}

TEST_CASE("What does not move with the surface, or stands before it, is not taken") {
  const Mesh shape = one_box();
  TextureBaker baker = started(shape);
  SUBCASE("background, where the object is smaller than its model") {
    Mesh real;  // stands back by 40 mm in the lower third of the new face
    add_box(real, {0, 0, 0.015F}, {0.16F, 0.12F, 0.07F});
    add_box(real, {0, 0.02F, -0.035F}, {0.16F, 0.08F, 0.03F});
    for (const double angle : {0.4, 0.46, 0.52}) {
      const auto level = static_cast<std::uint8_t>(2500 * (angle - 0.4) / 3 + 40);
      const cv::Mat frame = photograph(real, kPhotoCamera, turned(angle), as_it_is, {level, level, level});
      CHECK(baker.add_frame(frame, turned(angle), PoseSource::tracked).taken);
    }
    long real_surface = 0;
    long background = 0;
    for (const Texel& texel : surface_texels(baker.model())) {
      const bool known = texel.normal.y() < -0.9 && texel.rgba[3] != 0;
      real_surface += known && texel.p_object.z() > -0.02 ? 1 : 0;
      background += known && texel.p_object.z() < -0.025 && error_of_texel(texel) > 60 ? 1 : 0;
    }
    CHECK(real_surface > 800);
    CHECK(background < 10);  // some hundreds are seen; few of them look alike in two frames by chance
  }
  SUBCASE("a finger, 20 mm wide, over the edge to the new face") {
    for (const double angle : {0.4, 0.46, 0.52}) {
      cv::Mat frame = photograph(shape, kPhotoCamera, turned(angle));
      // It lies on the edge from the top face down to the new one, and moves with the box.
      const Eigen::Vector2d tip = kPhotoCamera.project(turned(angle) * Eigen::Vector3d(0.03, -0.06, 0.05));
      for (int y = 0; y < frame.rows; ++y) {
        for (int x = 0; x < frame.cols; ++x) {
          if ((Eigen::Vector2d(x, y) - tip).norm() < 8) {
            frame.at<cv::Vec3b>(y, x) = {250, 20, 250};
          }
        }
      }
      CHECK(baker.add_frame(frame, turned(angle), PoseSource::tracked).taken);
    }
    const NewFace face = new_face(baker, 60);
    CHECK(face.known > 800);
    CHECK(face.wrong == 0);
  }
  SUBCASE("a frame of something else") {
    cv::Mat other(kPhotoCamera.height, kPhotoCamera.width, CV_8UC3);
    cv::RNG(3).fill(other, cv::RNG::UNIFORM, 0, 255);
    const FrameUse use = baker.add_frame(other, turned(0.4), PoseSource::tracked);
    CHECK_FALSE(use.taken);
    CHECK(std::string(use.reason) == "differs from what is known");
    CHECK(use.agreement < 0.7);
  }
}

TEST_CASE("A tracked frame that is blurred by motion, whichever way, is not taken") {
  simulation::SequenceOptions options;
  options.frames = 1;
  const simulation::Sequence sequence(simulation::textured_box(), options);
  const cv::Mat sharp = sequence.frame(0);
  const Pose pose = sequence.pose(0);
  TextureBaker baker = make_baker(one_box(), sequence.camera(), pose, {}, {});
  CHECK(baker.add_frame(sharp, pose, PoseSource::given).taken);
  for (const cv::Size& motion : {cv::Size(9, 1), cv::Size(1, 9)}) {
    cv::Mat blurred;
    cv::blur(sharp, blurred, motion);
    const FrameUse use = baker.add_frame(blurred, pose, PoseSource::tracked);
    CHECK_FALSE(use.taken);
    CHECK(std::string(use.reason) == "blurred");
  }
  cv::Mat faint;
  sharp.convertTo(faint, CV_8U, 0.6, 20);
  const FrameUse use = baker.add_frame(faint, pose, PoseSource::tracked);
  CHECK(use.taken);
  CHECK(use.sharpness > 0.95);
}

TEST_CASE("A model begun with one frame is completed while it is tracked") {
  const Mesh box = simulation::textured_box();
  simulation::SequenceOptions options;
  options.camera = {480, 360, 480, 480, 239.5, 179.5, {}};
  options.frames = 70;
  options.samples = 2;
  options.lighting = simulation::LightingOptions::flat();
  for (int i = 0; i < options.frames; ++i) {
    // The right side turns in, 50 degrees within 70 frames.
    Pose pose = Pose::Identity();
    pose.linear() = Eigen::AngleAxisd(std::numbers::pi + 0.35, Eigen::Vector3d::UnitX()).toRotationMatrix() *
                    Eigen::AngleAxisd(0.25 - 0.0125 * i, Eigen::Vector3d::UnitY()).toRotationMatrix();
    pose.translation() = Eigen::Vector3d(0.02 - 0.0005 * i, 0.01, 0.42);
    options.motion.T_camera_object.push_back(pose);
  }
  const simulation::Sequence sequence(box, options);

  Mesh shape = box;
  shape.materials.clear();
  shape.triangle_materials.clear();
  shape.texture_coordinates.clear();
  ModelCompletion completion(shape, sequence.camera(), sequence.frame(0), sequence.pose(0));
  const double first = completion.first_coverage();
  Tracker tracker(completion.model(), sequence.camera());
  tracker.reset(sequence.pose(0));
  double largest_mm = 0;
  double largest_degrees = 0;
  for (int i = 0; i < sequence.size(); ++i) {
    const cv::Mat frame = sequence.frame(i);
    const FrameResult result = tracker.track(view_of(frame));
    CHECK(result.status == Status::held);
    const Pose error = sequence.pose(i).inverse() * result.T_camera_object;
    largest_mm = std::max(largest_mm, 1e3 * error.translation().norm());
    largest_degrees = std::max(largest_degrees, rotation_angle(error.linear()) * 180 / std::numbers::pi);
    completion.update(tracker, frame, result);
  }
  CAPTURE(first);
  CAPTURE(completion.coverage());
  CAPTURE(largest_mm);
  CAPTURE(largest_degrees);
  CHECK(largest_mm < 2);
  CHECK(largest_degrees < 0.5);
  // The side that turned in is 12 % of the surface.
  CHECK(completion.coverage() > first + 0.09);
  CHECK(completion.frames_taken() > 20);

  // The completed model, seen as the last frame, is that frame.
  const Mesh model = completion.model();
  const RayCaster caster(model, sequence.pose(sequence.size() - 1));
  const cv::Mat last = sequence.frame(sequence.size() - 1);
  double difference = 0;
  double count = 0;
  for (int y = 0; y < last.rows; y += 2) {
    for (int x = 0; x < last.cols; x += 2) {
      const auto hit = caster.cast(sequence.camera(), {x, y});
      if (!hit) {
        continue;
      }
      const Eigen::Vector4d color = caster.color(*hit);
      if (color[3] > 250) {
        const cv::Vec3b& pixel = last.at<cv::Vec3b>(y, x);
        difference +=
            (std::abs(color[0] - pixel[2]) + std::abs(color[1] - pixel[1]) + std::abs(color[2] - pixel[0])) / 3;
        ++count;
      }
    }
  }
  CHECK(count > 5000);
  CHECK(difference / count < 12);
}
