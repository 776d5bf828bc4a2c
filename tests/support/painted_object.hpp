#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "baking/model_completion.hpp"
#include "holdfast/mesh.hpp"
#include "support/ray_caster.hpp"

/// An object with paint on it, photographed by casting rays, and what a bake made of the photographs.
namespace holdfast::test {

inline const Camera kPhotoCamera{320, 240, 330, 325, 161.5, 117.2, {}};

void add_box(Mesh& mesh, const Eigen::Vector3f& center, const Eigen::Vector3f& size);
Mesh one_box();
/// A small box floats before the face x+ of a large one.
Mesh two_boxes();

using Light = std::function<Eigen::Vector3d(const Eigen::Vector3d& color, const Eigen::Vector3d& normal_object)>;

Eigen::Vector3d as_it_is(const Eigen::Vector3d& color, const Eigen::Vector3d& normal_object);

/// A frame of the painted object, by casting a ray through every pixel. Knows nothing of the renderer nor of textures.
cv::Mat photograph(const Mesh& mesh, const Camera& camera, const Pose& T_camera_object, const Light& light = as_it_is,
                   const cv::Vec3b& background = {10, 10, 10});

/// Object z up, x towards the camera, turned by yaw about its own z, then tipped by pitch.
Pose look(double yaw, double pitch, const Eigen::Vector3d& p_camera = {0.01, -0.005, 0.42});

/// 700 texels a metre.
baking::TextureOptions texture_options();

/// A texel of a baked model, found by the model's texture coordinates alone.
struct Texel {
  Eigen::Vector3d p_object;
  Eigen::Vector3d normal;
  std::array<std::uint8_t, 4> rgba;
  std::size_t index;
};

/// All texels whose centre lies on the surface, off the edges of triangles.
std::vector<Texel> surface_texels(const Mesh& mesh);

/// The largest over the channels, levels.
double error_of_texel(const Texel& texel);

/// Does the camera see this point of the surface, and nothing else but its surroundings within `radius` pixels?
enum class Sight { hidden, near_border, clear };

Sight sight_of(const RayCaster& caster, const Camera& camera, const Pose& T_camera_object, const Texel& texel,
               double radius);

}  // namespace holdfast::test
