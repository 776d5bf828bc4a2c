#include "simulation/sequence.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgcodecs.hpp>

#include "holdfast/error.hpp"
#include "simulation/random.hpp"

namespace holdfast::simulation {
namespace {

const SequenceOptions& validated(const SequenceOptions& options) {
  options.camera.validate();
  const auto check = [](bool fine, const char* what) {
    if (!fine) throw Error(ErrorCode::invalid_argument, std::string("sequence: ") + what);
  };
  check(options.frames >= 1, "there must be at least one frame");
  check(options.samples >= 1 && options.samples <= 16, "samples must be 1 to 16");
  check(options.motion_blur >= 0 && options.motion_blur <= 1, "motion blur must be 0 to 1 of a frame's time");
  check(options.lighting.ambient >= 0, "ambient light must not be negative");
  check(options.motion.T_camera_object.empty() ||
            static_cast<int>(options.motion.T_camera_object.size()) >= options.frames,
        "the trajectory has fewer poses than there are frames; give one a frame");
  return options;
}

Eigen::Vector3f bgr(const Eigen::Vector3d& rgb) { return rgb.reverse().cast<float>(); }

// Puts a layer over what is there.
void composite(const Layer& layer, cv::Mat& light) {
  for (int y = 0; y < layer.region.height; ++y) {
    const cv::Vec3f* in = layer.light.ptr<cv::Vec3f>(y);
    const float* object = layer.object_share.ptr<float>(y);
    const float* other = layer.other_share.ptr<float>(y);
    cv::Vec3f* out = light.ptr<cv::Vec3f>(layer.region.y + y) + layer.region.x;
    for (int x = 0; x < layer.region.width; ++x) {
      const float covered = object[x] + other[x];
      if (covered > 0) out[x] = in[x] + out[x] * (1.0f - covered);
    }
  }
}

double share_of(const Layer& layer) {
  if (layer.object_samples == 0) return 0;
  return static_cast<double>(layer.visible_samples) / static_cast<double>(layer.object_samples);
}

}  // namespace

Sequence::Sequence(const Mesh& object, const SequenceOptions& options)
    : options_(validated(options)),
      mesh_(object),
      corners_(bounding_corners(object)),
      lens_(options.camera),
      motion_(make_motion(options.motion, object, options.camera, options.frames, options.seed)),
      background_(options.background, cv::Size(options.camera.width, options.camera.height), options.seed),
      sensor_(options.sensor, options.seed) {
  for (std::size_t i = 0; i < options.occluders.size(); ++i) {
    occluders_.push_back(make_occluder(options.occluders[i], object, motion_, options.camera, options.frames,
                                       hash(options.seed, 0x0cc1, i)));
  }
}

void Sequence::check_index(int i) const {
  if (i < 0 || i >= options_.frames) {
    throw Error(ErrorCode::invalid_argument,
                "sequence: there is no frame " + std::to_string(i) + " of " + std::to_string(options_.frames));
  }
}

Pose Sequence::pose(int i) const {
  check_index(i);
  return motion_(i);
}

std::vector<Pose> Sequence::poses() const {
  std::vector<Pose> result;
  for (int i = 0; i < size(); ++i) result.push_back(pose(i));
  return result;
}

Scene Sequence::scene_at(double frame) const {
  Scene scene;
  scene.object = {&mesh_, motion_(frame), options_.lighting.finish};
  for (const Occluder& occluder : occluders_) {
    scene.occluders.push_back({&occluder.mesh, occluder.T_camera_occluder(frame), occluder.finish});
  }
  for (const LightOptions& light : options_.lighting.lights) {
    const double angle = 2.0 * std::numbers::pi * frame / light.orbit_frames;
    const Eigen::Vector3d orbit = light.orbit_radius * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
    scene.lights.push_back({light.position + orbit, static_cast<float>(light.intensity) * bgr(light.color)});
  }
  scene.ambient = Eigen::Vector3f::Constant(static_cast<float>(options_.lighting.ambient));
  return scene;
}

// Draws of one exposure: so many that from one to the next nothing moves by more than a pixel.
int Sequence::exposures(int i) const {
  if (options_.motion_blur == 0) return 1;
  const double half = 0.5 * options_.motion_blur;
  double farthest = corner_motion(corners_, options_.camera, motion_(i - half), motion_(i + half));
  for (const Occluder& o : occluders_) {
    farthest = std::max(farthest, corner_motion(o.corners, options_.camera, o.T_camera_occluder(i - half),
                                                o.T_camera_occluder(i + half)));
  }
  farthest = std::max(farthest, std::abs(options_.background.pan) * options_.motion_blur);
  return std::clamp(static_cast<int>(std::ceil(farthest)), 1, 48);
}

SimulatedFrame Sequence::make(int i) const {
  check_index(i);
  const cv::Size size(options_.camera.width, options_.camera.height);
  const int count = exposures(i);
  // Averaging many draws smooths by itself.
  const int samples = count >= 4 ? std::max(1, options_.samples - 1) : options_.samples;
  cv::Mat light = cv::Mat::zeros(size, CV_32FC3);
  cv::Mat object = cv::Mat::zeros(size, CV_32F);
  cv::Mat other = cv::Mat::zeros(size, CV_32F);
  SimulatedFrame result;
  result.T_camera_object = motion_(i);
  for (int k = 0; k < count; ++k) {
    const double time = i + options_.motion_blur * ((k + 0.5) / count - 0.5);
    const Layer layer = lens_.draw(scene_at(time), samples);
    cv::Mat instant = background_.at(time).clone();
    if (!layer.region.empty()) {
      composite(layer, instant);
      object(layer.region) += layer.object_share / count;
      other(layer.region) += layer.other_share / count;
    }
    if (count == 1) {
      light = instant;
      result.visible_share = share_of(layer);
    } else {
      cv::scaleAdd(instant, 1.0 / count, light, light);
    }
  }
  if (count > 1) result.visible_share = visible_share(i);
  result.image = sensor_.record(light, i);
  object.convertTo(result.object_mask, CV_8U, 255.0);
  other.convertTo(result.occluder_mask, CV_8U, 255.0);
  if (options_.sensor.jpeg_quality > 0) {
    cv::imencode(".jpg", result.image, result.jpeg, {cv::IMWRITE_JPEG_QUALITY, options_.sensor.jpeg_quality});
    result.image = cv::imdecode(result.jpeg, cv::IMREAD_COLOR);
  }
  return result;
}

double Sequence::visible_share(int i) const {
  check_index(i);
  return share_of(lens_.draw(scene_at(i), options_.samples, false));
}

}  // namespace holdfast::simulation
