#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/pose.hpp"

/// A CPU rasteriser that shares nothing with holdfast::Renderer: several samples a pixel, lighting in linear light, one
/// depth buffer for all objects. It makes the ground truth that the tracker is measured against.
namespace holdfast::simulation {

/// Linear light of an encoded (sRGB) value, both in [0, 1].
double linear_from_encoded(double value);
/// Encoded (sRGB) value of linear light, both in [0, 1].
double encoded_from_linear(double value);

/// A texture in linear light with its area-averaged pyramid.
class MipTexture {
 public:
  explicit MipTexture(const Texture& texture);
  int width() const { return levels_.front().width; }
  int height() const { return levels_.front().height; }

  /// What a sample stands for on the texture, in texels of the finest level: probes in a row, each averaging a square.
  struct Footprint {
    int probes = 1;
    Eigen::Vector2f step = Eigen::Vector2f::Zero();  ///< from probe to probe
    float level = 0;                                 ///< of the pyramid: log2 of the square's side
  };
  /// `across` and `down`: what the texture coordinate moves by from one sample to the next.
  static Footprint footprint(const Eigen::Vector2f& across, const Eigen::Vector2f& down);

  /// Linear BGR averaged over a footprint round `texel`. `repeat`: coordinates outside the texture wrap round.
  Eigen::Array3f sample(const Eigen::Vector2f& texel, const Footprint& footprint, bool repeat) const;

 private:
  struct Level {
    int width = 0;
    int height = 0;
    float scale_x = 1;  // texels of this level a texel of the finest
    float scale_y = 1;
    std::vector<std::array<std::uint16_t, 4>> texels;  // linear BGR, 65535 is white; the fourth is unused
  };
  Eigen::Array4f trilinear(const Eigen::Vector2f& texel, float level, bool repeat) const;
  static Eigen::Array4f bilinear(const Level& level, float x, float y, bool repeat);

  std::vector<Level> levels_;
};

/// A mesh made ready for drawing: normals (smooth across edges below 40 degrees), textures in linear light.
class DrawnMesh {
 public:
  /// Throws Error(model) when the mesh cannot be drawn.
  explicit DrawnMesh(const Mesh& mesh);

  struct Triangle {
    std::array<Eigen::Vector3d, 3> positions;  // object frame
    std::array<Eigen::Vector3d, 3> normals;    // object frame, unit
    std::array<Eigen::Vector2d, 3> texels;     // pixel coordinates of the texture (centres at integers)
    std::array<Eigen::Vector3f, 3> colors;     // linear BGR, where there is no texture
    int texture = -1;                          // index, or -1
  };
  const std::vector<Triangle>& triangles() const { return triangles_; }
  const std::vector<MipTexture>& textures() const { return textures_; }
  bool repeats() const { return repeats_; }

 private:
  std::vector<Triangle> triangles_;
  std::vector<MipTexture> textures_;
  bool repeats_ = false;
};

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
