#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/pose.hpp"
#include "simulation/background.hpp"
#include "simulation/lens.hpp"
#include "simulation/motion.hpp"
#include "simulation/occluder.hpp"
#include "simulation/rasterizer.hpp"
#include "simulation/sensor.hpp"

/// Image sequences with exact ground truth, made one frame at a time without touching the disk.
namespace holdfast::simulation {

struct LightOptions {
  Eigen::Vector3d position = Eigen::Vector3d(-0.6, -1.0, -0.3);  ///< camera frame, metres
  double intensity = 0.65;  ///< of a surface that faces it; with the ambient light, 1 shows a texture as it is
  Eigen::Vector3d color = Eigen::Vector3d::Ones();  ///< linear RGB
  double orbit_radius = 0;                          ///< metres: it circles round its position
  double orbit_frames = 150;                        ///< frames a turn
};

struct LightingOptions {
  double ambient = 0.45;
  std::vector<LightOptions> lights = {LightOptions()};
  Finish finish;  ///< of the object

  /// Every surface shows its texture's own colours, without shading.
  static LightingOptions flat() { return {1.0, {}, {}}; }
};

struct SequenceOptions {
  Camera camera = {640, 480, 650, 650, 319.5, 239.5, {}};
  int frames = 200;
  std::uint64_t seed = 1;
  int samples = 3;         ///< squared: samples a pixel
  double motion_blur = 0;  ///< exposure time as a share of a frame's time, centred on the frame's time
  MotionOptions motion;
  std::vector<OccluderOptions> occluders;
  LightingOptions lighting;
  BackgroundOptions background;
  SensorOptions sensor;
};

/// A frame and what is true of it.
struct SimulatedFrame {
  cv::Mat image;                   ///< CV_8UC3, BGR, after compression where that is asked for
  std::vector<std::uint8_t> jpeg;  ///< the compressed image; empty where compression is not asked for
  Pose T_camera_object;            ///< at the middle of the exposure
  double visible_share;            ///< of the object's silhouette inside the frame; 0 when it is out of view
  cv::Mat object_mask;             ///< CV_8U: share of the pixel in which the object is seen, times 255
  cv::Mat occluder_mask;           ///< CV_8U: share of the pixel in which an occluder is seen, times 255
};

/// Frames depend on the options alone: not on the order they are asked for, nor on threads. All methods may be called
/// from several threads.
class Sequence {
 public:
  /// Throws Error for options out of range, meshes that cannot be drawn and backgrounds that cannot be read.
  Sequence(const Mesh& object, const SequenceOptions& options);

  int size() const { return options_.frames; }
  const SequenceOptions& options() const { return options_; }
  const Camera& camera() const { return options_.camera; }

  /// Everything about frame i, for the price of drawing it once. Throws Error(invalid_argument) when there is none.
  SimulatedFrame make(int i) const;

  Pose pose(int i) const;
  std::vector<Pose> poses() const;
  cv::Mat frame(int i) const { return make(i).image; }
  /// Far cheaper than the frame.
  double visible_share(int i) const;
  cv::Mat occluder_mask(int i) const { return make(i).occluder_mask; }

 private:
  Scene scene_at(double frame) const;
  int exposures(int i) const;
  void check_index(int i) const;

  SequenceOptions options_;
  DrawnMesh mesh_;
  std::array<Eigen::Vector3d, 8> corners_;
  Lens lens_;
  PoseAt motion_;
  std::vector<Occluder> occluders_;
  Background background_;
  Sensor sensor_;
};

}  // namespace holdfast::simulation
