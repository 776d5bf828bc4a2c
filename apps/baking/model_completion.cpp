#include "baking/model_completion.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "baking/unwrap.hpp"
#include "holdfast/error.hpp"

namespace holdfast::baking {
namespace {

/// A texel that another look was averaged into changed this much less than one that is new.
constexpr double kAveragedNews = 0.1;
/// Share of texels on two places of the surface that is no mere overlap at the border of charts.
constexpr double kMostShared = 0.01;

/// Pixels a metre of surface that faces the camera where the object is nearest.
double camera_resolution(const Mesh& mesh, const Camera& camera, const Pose& T_camera_object) {
  double nearest = 0;
  for (const Eigen::Vector3f& p : mesh.positions) {
    const double z = (T_camera_object * p.cast<double>()).z();
    nearest = z > 0 && (nearest == 0 || z < nearest) ? z : nearest;
  }
  if (nearest <= 0) {
    throw Error(ErrorCode::pose,
                "the pose puts the object behind the camera; poses map object to camera coordinates, z forward");
  }
  return std::max(camera.fx, camera.fy) / nearest;
}

bool has_texture(const Mesh& mesh) {
  return !mesh.texture_coordinates.empty() &&
         std::any_of(mesh.materials.begin(), mesh.materials.end(),
                     [](const Material& material) { return !material.texture.empty(); });
}

}  // namespace

TextureBaker make_baker(const Mesh& mesh, const Camera& camera, const Pose& T_camera_object,
                        const TextureOptions& textures, const BakeOptions& options) {
  mesh.validate();
  camera.validate();
  const double density =
      textures.texels_per_metre > 0 ? textures.texels_per_metre : camera_resolution(mesh, camera, T_camera_object);
  if (textures.unwrap || mesh.texture_coordinates.empty()) {
    UnwrapOptions unwrapping;
    unwrapping.texels_per_metre = density;
    unwrapping.padding = textures.padding;
    unwrapping.largest_size = textures.largest_size;
    const Unwrapped unwrapped = unwrap(mesh, unwrapping);
    return TextureBaker(unwrapped.mesh, {{unwrapped.width, unwrapped.height}}, camera, options);
  }
  std::vector<cv::Size> sizes = texture_sizes(mesh, density, textures.largest_size);
  const bool keep = textures.keep && has_texture(mesh);
  if (keep) {
    for (std::size_t m = 0; m < mesh.materials.size(); ++m) {
      const Texture& texture = mesh.materials[m].texture;
      sizes[m] = texture.empty() ? sizes[m] : cv::Size(texture.width, texture.height);
    }
  }
  return TextureBaker(mesh, sizes, camera, options, keep);
}

std::optional<std::string> coordinate_doubt(const TextureBaker& baker) {
  if (baker.shared() < kMostShared) return std::nullopt;
  return std::to_string(std::lround(100 * baker.shared())) +
         " % of the texture lies on two or more places of the surface, which all get what one of them shows: "
         "'holdfast bake --unwrap' gives each its own";
}

ModelCompletion::ModelCompletion(const Mesh& mesh, const Camera& camera, const cv::Mat& first_frame,
                                 const Pose& T_camera_object, const CompletionOptions& options)
    : options_(options), baker_(make_baker(mesh, camera, T_camera_object, options.textures, options.bake)) {
  if (baker_.coverage() == 0) {
    const FrameUse use = baker_.add_frame(first_frame, T_camera_object, PoseSource::given);
    frames_taken_ = use.taken ? 1 : 0;
  }
  first_coverage_ = baker_.coverage();
  if (first_coverage_ == 0) {
    throw Error(ErrorCode::pose,
                "the first frame shows nothing of the model at the first pose; check the pose's unit "
                "(metres) and axes (x right, y down, z forward), and the camera's focal length");
  }
}

bool ModelCompletion::is_trustworthy(const FrameResult& result) const {
  return result.status == Status::held && result.texture.correlation >= options_.least_correlation &&
         result.texture.residual <= options_.largest_residual &&
         result.texture.used_pixels >= options_.least_used_share * result.texture.gradient_pixels;
}

bool ModelCompletion::update(Tracker& tracker, const cv::Mat& frame, const FrameResult& result) {
  const std::int64_t number = frames_++;
  const bool opening = number < options_.opening_frames;
  if ((!opening && number % options_.every != 0) || !is_trustworthy(result)) {
    return false;
  }
  const FrameUse use =
      baker_.add_frame(frame, result.T_camera_object, opening ? PoseSource::opening : PoseSource::tracked);
  if (!use.taken) {
    return false;
  }
  ++frames_taken_;
  news_ += static_cast<double>(use.new_texels + use.replaced) + kAveragedNews * static_cast<double>(use.averaged);
  if (news_ >= options_.least_news * static_cast<double>(baker_.surface_texels())) {
    for (std::size_t m = 0; m < baker_.material_count(); ++m) {
      tracker.set_texture(m, baker_.texture(m, false));
    }
    news_ = 0;
  }
  return true;
}

}  // namespace holdfast::baking
