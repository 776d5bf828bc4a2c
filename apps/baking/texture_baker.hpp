#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "baking/candidate_views.hpp"
#include "baking/frame_sharpness.hpp"
#include "baking/mesh_topology.hpp"
#include "baking/photometric_match.hpp"
#include "baking/texel_map.hpp"
#include "baking/visible_surface.hpp"
#include "holdfast/camera.hpp"
#include "holdfast/mesh.hpp"
#include "holdfast/pose.hpp"

namespace holdfast::baking {

struct BakeOptions {
  int margin = 4;                ///< pixels left out at silhouettes, depth jumps and the frame's border
  double least_cosine = 0.25;    ///< between the surface's normal and the view; flatter views are not taken
  double tolerance = 20;         ///< levels of 255 between colours that count as the same
  double least_agreement = 0.7;  ///< of a tracked frame, see FrameUse
  double least_sharpness = 0.5;  ///< of a tracked frame, see FrameUse
  double better_view = 1.5;      ///< how much better a view must see a texel to replace what a tracked frame gave
  double confirming_motion = 3;  ///< pixels that the object moved between two tracked frames that confirm each other
  int looks = 16;                ///< views of about the same quality that a texel is averaged over, at most
};

/// How well a frame's pose is known.
enum class PoseSource {
  given,    ///< as well as ever: of the views, each texel takes the best
  opening,  ///< tracked, right after a given pose: no drift yet. As tracked, and evens out the noise of what was given
  tracked,  ///< found with this very texture: adds what is not known, never touches what a given pose brought
};

/// What became of a frame.
struct FrameUse {
  bool taken = false;
  const char* reason = "";      ///< why not
  std::size_t new_texels = 0;   ///< known now
  std::size_t replaced = 0;     ///< known before, seen better now
  std::size_t averaged = 0;     ///< known before, seen as well now
  double sharpness = 1;         ///< 1: as sharp as the sharpest frame before
  double agreement = 1;         ///< share of what is known and in view that looks in the frame as it should
  PhotometricMatch photometry;  ///< of the frame to the texture
};

/// Makes the textures of a mesh with texture coordinates from frames with poses. A texel becomes known when a frame
/// sees its place on the surface; what was never seen keeps alpha 0. A texel is the mean of the first few good looks at
/// it, which evens out the noise of the camera and of compression; then it stays.
///
/// Later frames are matched in brightness and contrast, a channel, to what is known already. Tracked frames give
/// nothing near places where they do not look like what is known, and a texel is taken only after two of them, between
/// which the object moved, agreed on its colour: background beside a wrong outline does not move with the surface.
class TextureBaker {
 public:
  /// `sizes`: of each material's texture. `keep`: what the mesh's textures know (alpha above 250) is kept as if a given
  /// pose had brought it; their sizes must be `sizes` then. Throws Error(model, renderer, camera).
  TextureBaker(const Mesh& mesh, const std::vector<cv::Size>& sizes, const Camera& camera,
               const BakeOptions& options = {}, bool keep = false);

  /// Takes from a frame (BGR8, as recorded: with lens distortion) what it shows. Throws Error(image) for a frame of
  /// another size than the camera's, Error(pose).
  FrameUse add_frame(const cv::Mat& bgr, const Pose& T_camera_object, PoseSource source);

  /// Share of the surface's area that is known.
  double coverage() const { return surface_area_ > 0 ? known_area_ / surface_area_ : 0; }

  /// A material's texture. `fill`: never-seen texels get the colour of a known one nearby (alpha stays 0), for viewers
  /// that do not know what alpha 0 means.
  Texture texture(std::size_t material, bool fill) const;
  std::size_t material_count() const { return map_.sizes.size(); }
  std::size_t surface_texels() const { return map_.surface.size(); }
  /// Share of the texels that lie on two places of the surface and were not known at first.
  double shared() const { return shared_; }

  /// The mesh with the textures as they are now, filled.
  Mesh model() const;

 private:
  enum class State : std::uint8_t {
    unknown,
    candidate,  // seen by one tracked frame
    tracked,    // known from tracked frames
    given,      // known from a given pose
  };

  /// A texel as the frame shows it.
  struct Sighting {
    std::uint32_t texel;
    std::uint32_t triangle;
    float score;           // pixels a metre, foreshortened and blurred
    std::uint16_t cell_x;  // of the frame, see compare()
    std::uint16_t cell_y;
    ColorF color;
  };

  void keep_known(const Mesh& mesh);
  double measure_sharpness(const cv::Mat& bgr);
  void collect(const cv::Mat& bgr, const Pose& T_camera_object, PoseSource source, double sharpness);
  bool is_compared(std::uint32_t texel) const;
  PhotometricMatch match() const;
  /// What the frame shows of what is known.
  struct Comparison {
    cv::Mat differing;     // CV_8U, a cell of the frame: not 0 in and next to those that do not look as they should
    double agreement = 1;  // share of the compared cells that do
  };
  Comparison compare(const PhotometricMatch& match) const;
  ColorF matched_color(const Sighting& sighting, const PhotometricMatch& match) const {
    return match.to_texture(sighting.color, topology_.normals[sighting.triangle].cast<float>());
  }
  void take(const Sighting& sighting, const ColorF& color, PoseSource source, std::uint16_t view, FrameUse& use);
  void learn(const Sighting& sighting, const ColorF& color, State state, FrameUse& use);
  bool is_wanted(std::uint32_t texel, float score, PoseSource source) const;
  bool is_better(std::uint32_t texel, float score, PoseSource source) const;
  bool is_as_good(std::uint32_t texel, float score, PoseSource source) const;
  std::uint16_t add_view(const Pose& T_camera_object);

  Mesh mesh_;  // without textures
  Camera camera_;
  BakeOptions options_;
  MeshTopology topology_;
  TexelMap map_;
  VisibleSurface visible_;
  double surface_area_ = 0;
  double known_area_ = 0;
  double shared_ = 0;
  std::optional<FrameSharpness> sharpest_;

  // One a texel:
  std::vector<ColorF> colors_;
  std::vector<State> states_;
  std::vector<std::uint8_t> looks_;   // that the colour is the mean of
  std::vector<float> scores_;         // of the view that brought it
  std::vector<std::uint16_t> views_;  // of a candidate

  CandidateViews candidate_views_;

  std::vector<Sighting> sightings_;  // of the last frame
};

}  // namespace holdfast::baking
