#include "baking/texture_baker.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <string>

#include "baking/frame_pyramid.hpp"
#include "baking/nearest_zero.hpp"
#include "holdfast/error.hpp"

namespace holdfast::baking {
namespace {

/// Of the texels that are known, one in so many is compared with the frame.
constexpr std::uint32_t kComparedShare = 5;
/// Cells of the frame in which what is known is compared with it, pixels a side, and how much of it there must be.
constexpr int kCell = 8;
constexpr float kLeastCompared = 4;
/// More pairs of colours than that make a photometric match no better.
constexpr std::size_t kMostPairs = 3000;
/// A given pose's view replaces another one's when it is this much better: no patchwork of nearly equal views.
constexpr float kBetterGivenView = 1.25F;
/// Views down to this share of a texel's score are averaged with it.
constexpr float kAsGood = 0.8F;

/// Mean over the channels.
float difference(const ColorF& a, const ColorF& b) {
  return (std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2])) / 3;
}

Mesh without_textures(Mesh mesh) {
  if (mesh.materials.empty()) {
    mesh.materials.push_back({"baked", {}});
  }
  for (Material& material : mesh.materials) {
    material.texture = {};
  }
  mesh.colors.clear();  // they would show through where nothing is known
  return mesh;
}

/// Gives texels of alpha 0 the colour of the nearest other one.
void fill_unknown(Texture& texture) {
  cv::Mat unknown(texture.height, texture.width, CV_8U);
  for (std::size_t i = 0; i < unknown.total(); ++i) {
    unknown.data[i] = texture.rgba[4 * i + 3] == 0 ? 255 : 0;
  }
  const std::vector<std::uint32_t> nearest = nearest_zero(unknown, std::numeric_limits<float>::max());
  for (std::size_t i = 0; i < nearest.size(); ++i) {
    std::copy_n(texture.rgba.data() + 4 * static_cast<std::size_t>(nearest[i]), 3, texture.rgba.data() + 4 * i);
  }
}

}  // namespace

TextureBaker::TextureBaker(const Mesh& mesh, const std::vector<cv::Size>& sizes, const Camera& camera,
                           const BakeOptions& options, bool keep)
    : mesh_(without_textures(mesh)),
      camera_(camera),
      options_(options),
      topology_(topology_of(mesh_)),
      map_(map_texels(mesh_, sizes)),
      visible_(mesh_, camera),
      candidate_views_(mesh_, camera, options.confirming_motion) {
  colors_.assign(map_.count(), ColorF{});
  states_.assign(map_.count(), State::unknown);
  looks_.assign(map_.count(), 0);
  scores_.assign(map_.count(), 0);
  views_.assign(map_.count(), 0);
  for (std::size_t t = 0; t + 1 < map_.triangles.size(); ++t) {
    surface_area_ += static_cast<double>(map_.area[t]) * (map_.triangles[t + 1] - map_.triangles[t]);
  }
  if (keep) {
    keep_known(mesh);
  }
  for (std::size_t i = 0; i < map_.shared.size(); ++i) {
    shared_ += map_.shared[i] != 0 && states_[i] == State::unknown ? 1.0 / static_cast<double>(surface_texels()) : 0.0;
  }
}

void TextureBaker::keep_known(const Mesh& mesh) {
  for (std::size_t m = 0; m < mesh.materials.size(); ++m) {
    const Texture& texture = mesh.materials[m].texture;
    if (texture.empty()) {
      continue;
    }
    if (texture.width != map_.sizes[m].width || texture.height != map_.sizes[m].height) {
      throw Error(ErrorCode::model, "the texture of material " + std::to_string(m) + " is " +
                                        std::to_string(texture.width) + "x" + std::to_string(texture.height) +
                                        " texels, but " + std::to_string(map_.sizes[m].width) + "x" +
                                        std::to_string(map_.sizes[m].height) + " are to be kept; scale it");
    }
    for (std::uint32_t i = 0; i < map_.first[m + 1] - map_.first[m]; ++i) {
      const std::uint8_t* rgba = texture.rgba.data() + 4 * static_cast<std::size_t>(i);
      if (rgba[3] >= kKnownAlpha) {
        colors_[map_.first[m] + i] = {static_cast<float>(rgba[2]), static_cast<float>(rgba[1]),
                                      static_cast<float>(rgba[0])};
        states_[map_.first[m] + i] = State::given;
        // What is there already was made for this: no view is better.
        scores_[map_.first[m] + i] = std::numeric_limits<float>::max();
      }
    }
  }
  for (std::size_t t = 0; t + 1 < map_.triangles.size(); ++t) {
    for (std::uint32_t i = map_.triangles[t]; i < map_.triangles[t + 1]; ++i) {
      known_area_ += states_[map_.surface[i].texel] == State::given ? static_cast<double>(map_.area[t]) : 0.0;
    }
  }
}

FrameUse TextureBaker::add_frame(const cv::Mat& bgr, const Pose& T_camera_object, PoseSource source) {
  if (bgr.type() != CV_8UC3 || bgr.cols != camera_.width || bgr.rows != camera_.height) {
    throw Error(ErrorCode::image, "baking: the frame has " + std::to_string(bgr.cols) + "x" + std::to_string(bgr.rows) +
                                      " pixels, the camera " + std::to_string(camera_.width) + "x" +
                                      std::to_string(camera_.height) + "; frames must be BGR8 of the camera's size");
  }
  validate_pose(T_camera_object);
  FrameUse use;
  visible_.draw(T_camera_object, options_.margin);
  if (visible_.region().empty()) {
    use.reason = "out of view";
    return use;
  }
  use.sharpness = measure_sharpness(bgr);
  if (source != PoseSource::given && use.sharpness < options_.least_sharpness) {
    use.reason = "blurred";
    return use;
  }
  collect(bgr, T_camera_object, source, use.sharpness);
  use.photometry = match();
  const Comparison comparison = compare(use.photometry);
  use.agreement = comparison.agreement;
  if (source != PoseSource::given && use.agreement < options_.least_agreement) {
    use.reason = "differs from what is known";
    return use;
  }
  use.taken = true;
  const std::uint16_t view = source == PoseSource::given ? std::uint16_t{0} : add_view(T_camera_object);
  for (const Sighting& sighting : sightings_) {
    const bool differs = comparison.differing.at<std::uint8_t>(sighting.cell_y, sighting.cell_x) != 0;
    if (source == PoseSource::given || !differs) {
      take(sighting, matched_color(sighting, use.photometry), source, view, use);
    }
  }
  return use;
}

/// Relative to the sharpest frame so far; remembers this one when it is sharper.
double TextureBaker::measure_sharpness(const cv::Mat& bgr) {
  const FrameSharpness sharpness = frame_sharpness(bgr(visible_.region()), visible_.safe());
  const double relative = sharpest_ ? sharpness.relative_to(*sharpest_) : 1;
  if (!sharpest_ || relative > 1) {
    sharpest_ = sharpness;
  }
  return std::min(relative, 1.0);
}

bool TextureBaker::is_better(std::uint32_t texel, float score, PoseSource source) const {
  if (source == PoseSource::given) {
    return states_[texel] != State::given || score > kBetterGivenView * scores_[texel];
  }
  return states_[texel] != State::given && static_cast<double>(score) > options_.better_view * scores_[texel];
}

bool TextureBaker::is_as_good(std::uint32_t texel, float score, PoseSource source) const {
  const bool open = states_[texel] != State::given || source != PoseSource::tracked;
  return open && looks_[texel] < options_.looks && score >= kAsGood * scores_[texel];
}

bool TextureBaker::is_wanted(std::uint32_t texel, float score, PoseSource source) const {
  return states_[texel] < State::tracked || is_better(texel, score, source) || is_as_good(texel, score, source);
}

/// Looks up every texel that the frame shows and that is wanted or compared.
void TextureBaker::collect(const cv::Mat& bgr, const Pose& T_camera_object, PoseSource source, double sharpness) {
  sightings_.clear();
  FramePyramid frame(bgr);
  const bool distorted = camera_.has_distortion();
  const Eigen::Matrix3f R = T_camera_object.linear().cast<float>();
  const Eigen::Vector3f t_camera = T_camera_object.translation().cast<float>();
  const Eigen::Vector3d camera_center = T_camera_object.inverse().translation();
  const auto fx = static_cast<float>(camera_.fx);
  const auto fy = static_cast<float>(camera_.fy);
  const auto cx = static_cast<float>(camera_.cx);
  const auto cy = static_cast<float>(camera_.cy);
  const float f = std::sqrt(fx * fy);
  const auto blur = static_cast<float>(sharpness);
  for (std::size_t t = 0; t + 1 < map_.triangles.size(); ++t) {
    if (map_.triangles[t] == map_.triangles[t + 1] || topology_.areas[t] <= 0) {
      continue;
    }
    const Eigen::Vector3d p_corner = mesh_.positions[mesh_.triangles[t][0]].cast<double>();
    const double facing = topology_.normals[t].dot(camera_center - p_corner) * (topology_.inside_out ? -1 : 1);
    if (topology_.closed && facing <= 0) {
      continue;
    }
    const Eigen::Vector3f n_camera = R * topology_.normals[t].cast<float>();
    const float texel_side = std::sqrt(map_.area[t]);
    for (std::uint32_t i = map_.triangles[t]; i < map_.triangles[t + 1]; ++i) {
      const std::uint32_t texel = map_.surface[i].texel;
      const bool compared = is_compared(texel);
      if (!compared && !is_wanted(texel, std::numeric_limits<float>::infinity(), source)) {
        continue;
      }
      const Eigen::Vector3f p_camera = R * map_.surface[i].p_object + t_camera;
      if (p_camera.z() <= 0) {
        continue;
      }
      const float u = fx * p_camera.x() / p_camera.z() + cx;
      const float v = fy * p_camera.y() / p_camera.z() + cy;
      if (!visible_.sees(u, v, p_camera.z())) {
        continue;
      }
      const float cosine = std::abs(n_camera.dot(p_camera)) / p_camera.norm();
      if (static_cast<double>(cosine) < options_.least_cosine) {
        continue;
      }
      const float score = blur * cosine * f / p_camera.z();
      if (!compared && !is_wanted(texel, score, source)) {
        continue;
      }
      Eigen::Vector2f pixel(u, v);
      if (distorted) {
        pixel = camera_.distort(pixel.cast<double>()).cast<float>();
        if (pixel.minCoeff() < 0 || pixel.x() > static_cast<float>(bgr.cols - 1) ||
            pixel.y() > static_cast<float>(bgr.rows - 1)) {
          continue;
        }
      }
      sightings_.push_back({texel, static_cast<std::uint32_t>(t), score, static_cast<std::uint16_t>(u / kCell),
                            static_cast<std::uint16_t>(v / kCell),
                            frame.sample(pixel.x(), pixel.y(), texel_side * f / p_camera.z())});
    }
  }
}

bool TextureBaker::is_compared(std::uint32_t texel) const {
  return states_[texel] >= State::tracked && texel % kComparedShare == 0;
}

PhotometricMatch TextureBaker::match() const {
  std::vector<ColorPair> pairs;
  for (const Sighting& sighting : sightings_) {
    if (is_compared(sighting.texel)) {
      pairs.push_back({colors_[sighting.texel], sighting.color, topology_.normals[sighting.triangle].cast<float>()});
    }
  }
  if (pairs.size() > kMostPairs) {
    const std::size_t step = pairs.size() / kMostPairs + 1;
    for (std::size_t i = 0; i * step < pairs.size(); ++i) {
      pairs[i] = pairs[i * step];
    }
    pairs.resize((pairs.size() - 1) / step + 1);
  }
  return match_photometry(pairs, options_.tolerance);
}

/// The colours of a cell are compared in the mean, which an error of the pose by a pixel or two does not change much.
TextureBaker::Comparison TextureBaker::compare(const PhotometricMatch& match) const {
  const cv::Size size(camera_.width / kCell + 1, camera_.height / kCell + 1);
  cv::Mat sums = cv::Mat::zeros(size, CV_32FC4);
  for (const Sighting& sighting : sightings_) {
    if (!is_compared(sighting.texel)) {
      continue;
    }
    const ColorF shown = matched_color(sighting, match);
    auto& sum = sums.at<cv::Vec4f>(sighting.cell_y, sighting.cell_x);
    for (int c = 0; c < 3; ++c) {
      sum[c] += shown[static_cast<std::size_t>(c)] - colors_[sighting.texel][static_cast<std::size_t>(c)];
    }
    sum[3] += 1;
  }
  Comparison comparison;
  comparison.differing = cv::Mat::zeros(size, CV_8U);
  int compared = 0;
  int differing = 0;
  const auto allowed = static_cast<float>(3 * options_.tolerance);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const auto& sum = sums.at<cv::Vec4f>(y, x);
      if (sum[3] < kLeastCompared) {
        continue;
      }
      ++compared;
      if (std::abs(sum[0]) + std::abs(sum[1]) + std::abs(sum[2]) > allowed * sum[3]) {
        ++differing;
        comparison.differing.at<std::uint8_t>(y, x) = 255;
      }
    }
  }
  cv::dilate(comparison.differing, comparison.differing, cv::Mat());
  comparison.agreement = compared > 0 ? 1 - static_cast<double>(differing) / compared : 1;
  return comparison;
}

void TextureBaker::learn(const Sighting& sighting, const ColorF& color, State state, FrameUse& use) {
  if (states_[sighting.texel] < State::tracked) {
    known_area_ += static_cast<double>(map_.area[sighting.triangle]);
    ++use.new_texels;
  } else {
    ++use.replaced;
  }
  colors_[sighting.texel] = color;
  states_[sighting.texel] = state;
  looks_[sighting.texel] = 1;
  scores_[sighting.texel] = sighting.score;
}

void TextureBaker::take(const Sighting& sighting, const ColorF& color, PoseSource source, std::uint16_t view,
                        FrameUse& use) {
  const std::uint32_t texel = sighting.texel;
  const bool alike = static_cast<double>(difference(color, colors_[texel])) <= options_.tolerance;
  if (states_[texel] >= State::tracked) {
    if (is_better(texel, sighting.score, source)) {
      learn(sighting, color, source == PoseSource::given ? State::given : State::tracked, use);
    } else if (alike && is_as_good(texel, sighting.score, source)) {
      const float share = 1.0F / static_cast<float>(++looks_[texel]);
      for (std::size_t c = 0; c < 3; ++c) {
        colors_[texel][c] += share * (color[c] - colors_[texel][c]);
      }
      ++use.averaged;
    }
    return;
  }
  if (source == PoseSource::given) {
    learn(sighting, color, State::given, use);
    return;
  }
  if (states_[texel] == State::candidate) {
    if (!candidate_views_.moved_since(views_[texel])) {
      return;
    }
    if (alike) {
      const bool better = sighting.score > scores_[texel];
      Sighting best = sighting;
      best.score = std::max(sighting.score, scores_[texel]);
      learn(best, better ? color : ColorF(colors_[texel]), State::tracked, use);
      return;
    }
  }
  colors_[texel] = color;
  states_[texel] = State::candidate;
  scores_[texel] = sighting.score;
  views_[texel] = view;
}

/// The view's number for candidates, which wait for so many views at most.
std::uint16_t TextureBaker::add_view(const Pose& T_camera_object) {
  if (candidate_views_.full()) {
    for (State& state : states_) {
      state = state == State::candidate ? State::unknown : state;
    }
    candidate_views_.clear();
  }
  return candidate_views_.add(T_camera_object);
}

Texture TextureBaker::texture(std::size_t material, bool fill) const {
  const cv::Size size = map_.sizes.at(material);
  const std::uint32_t first = map_.first[material];
  Texture texture;
  texture.width = size.width;
  texture.height = size.height;
  texture.rgba.assign(4 * static_cast<std::size_t>(size.area()), 0);
  const auto put = [&](std::uint32_t texel, std::uint32_t source) {
    if (states_[source] >= State::tracked) {
      std::uint8_t* rgba = texture.rgba.data() + 4 * static_cast<std::size_t>(texel - first);
      for (std::size_t c = 0; c < 3; ++c) {  // BGR to RGB
        rgba[c] = static_cast<std::uint8_t>(colors_[source][2 - c] + 0.5F);
      }
      rgba[3] = 255;
    }
  };
  for (std::uint32_t i = first; i < map_.first[material + 1]; ++i) {
    put(i, i);
  }
  for (const TexelMap::Padding& padding : map_.padding) {
    if (padding.texel >= first && padding.texel < map_.first[material + 1]) {
      put(padding.texel, padding.source);
    }
  }
  if (fill) {
    fill_unknown(texture);
  }
  return texture;
}

Mesh TextureBaker::model() const {
  Mesh mesh = mesh_;
  for (std::size_t m = 0; m < material_count(); ++m) {
    mesh.materials[m].texture = texture(m, true);
  }
  return mesh;
}

}  // namespace holdfast::baking
