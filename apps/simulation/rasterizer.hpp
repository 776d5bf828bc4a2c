#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/pose.hpp"
#include "simulation/drawn_mesh.hpp"

/// A CPU rasteriser that shares nothing with holdfast::Renderer: several samples a pixel, lighting in linear light, one
/// depth buffer for all objects. It makes the ground truth that the tracker is measured against.
namespace holdfast::simulation {

/// A point light in the camera frame, without fall-off.
struct PointLight {
  Eigen::Vector3d position = Eigen::Vector3d(-0.6, -1.0, -0.3);  ///< metres
  Eigen::Vector3f color = Eigen::Vector3f::Ones();               ///< linear BGR, times the intensity
};

/// What a surface does with light: Lambert's law and a Blinn-Phong highlight of the light's colour.
struct Finish {
  double specular = 0.0;    ///< strength of the highlight; 0: matt
  double shininess = 40.0;  ///< exponent: larger is a smaller, sharper highlight
};

struct SceneObject {
  const DrawnMesh* mesh = nullptr;
  Pose T_camera_object = Pose::Identity();
  Finish finish;
};

struct Scene {
  SceneObject object;                  ///< the one whose visible share is counted
  std::vector<SceneObject> occluders;  ///< whatever else is there, in front or behind
  std::vector<PointLight> lights;
  Eigen::Vector3f ambient = Eigen::Vector3f::Constant(0.5f);  ///< linear BGR
};

/// What the objects of a scene add to a frame.
struct Layer {
  cv::Rect region;       ///< of the frame; empty: nothing is in view
  cv::Mat light;         ///< CV_32FC3 of the region: linear BGR times the share of the pixel that objects cover
  cv::Mat object_share;  ///< CV_32F of the region: share of the pixel in which the object is seen
  cv::Mat other_share;   ///< CV_32F of the region: share of the pixel in which an occluder is seen
  std::int64_t object_samples = 0;   ///< of the object's silhouette inside the frame
  std::int64_t visible_samples = 0;  ///< of these, with nothing in front
};

/// Draws a scene with `samples` x `samples` samples a pixel; the camera's lens distortion is left out (lens.hpp adds
/// it). With `shade` false only the shares and counts are made.
Layer draw(const Scene& scene, const Camera& camera, int samples, bool shade = true);

}  // namespace holdfast::simulation
