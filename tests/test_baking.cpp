#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>
#include <vector>

#include "baking/model_completion.hpp"
#include "baking/photometric_match.hpp"
#include "baking/texture_baker.hpp"
#include "holdfast/error.hpp"
#include "simulation/motion.hpp"
#include "simulation/sequence.hpp"
#include "simulation/textured_box.hpp"
#include "support/files.hpp"
#include "support/ray_caster.hpp"

using namespace holdfast;
using namespace holdfast::baking;
using holdfast::test::error_of;
using holdfast::test::RayCaster;
using holdfast::test::RayHit;

namespace {

const Camera kCamera{320, 240, 330, 325, 161.5, 117.2, {}};

void add_box(Mesh& mesh, const Eigen::Vector3f& center, const Eigen::Vector3f& size) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (int i = 0; i < 8; ++i) {
    mesh.positions.push_back(center + 0.5F * Eigen::Vector3f((i & 1) != 0 ? size.x() : -size.x(),
                                                             (i & 2) != 0 ? size.y() : -size.y(),
                                                             (i & 4) != 0 ? size.z() : -size.z()));
  }
  for (const auto& [a, b, c] : {std::array<std::uint32_t, 3>{0, 2, 1},
                                {1, 2, 3},
                                {4, 5, 6},
                                {5, 7, 6},
                                {0, 1, 4},
                                {1, 5, 4},
                                {2, 6, 3},
                                {3, 6, 7},
                                {0, 4, 2},
                                {2, 4, 6},
                                {1, 3, 5},
                                {3, 7, 5}}) {
    mesh.triangles.push_back({first + a, first + b, first + c});
  }
}

Mesh one_box() {
  Mesh mesh;
  add_box(mesh, {0, 0, 0}, {0.16F, 0.12F, 0.1F});
  return mesh;
}

/// A small box floats before the face x+ of a large one.
Mesh two_boxes() {
  Mesh mesh;
  add_box(mesh, {0, 0, 0}, {0.08F, 0.16F, 0.12F});
  add_box(mesh, {0.09F, 0.01F, 0.01F}, {0.03F, 0.05F, 0.04F});
  return mesh;
}

/// What is painted on the object: smooth waves, so that sampling them at pixels loses nothing. BGR.
Eigen::Vector3d paint(const Eigen::Vector3d& p_object) {
  const Eigen::Vector3d waves(std::sin(70 * p_object.x() + 40 * p_object.z()), std::sin(55 * p_object.y() + 1.0),
                              std::cos(50 * p_object.z() - 45 * p_object.x() + 30 * p_object.y()));
  return Eigen::Vector3d(120, 130, 110) + 70 * waves;
}

/// The pixel of the ideal frame that lens distortion puts at `recorded`.
Eigen::Vector2d undistorted(const Camera& camera, const Eigen::Vector2d& recorded) {
  Eigen::Vector2d pixel = recorded;
  for (int i = 0; i < 50; ++i) {
    pixel += recorded - camera.distort(pixel);
  }
  return pixel;
}

using Light = std::function<Eigen::Vector3d(const Eigen::Vector3d& color, const Eigen::Vector3d& normal_object)>;

Eigen::Vector3d as_it_is(const Eigen::Vector3d& color, const Eigen::Vector3d& /*normal*/) { return color; }

Eigen::Vector3d point_of(const Mesh& mesh, const RayHit& hit) {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    p += hit.weights[k] * mesh.positions[mesh.triangles[hit.triangle][static_cast<std::size_t>(k)]].cast<double>();
  }
  return p;
}

Eigen::Vector3d normal_of(const Mesh& mesh, std::size_t t) {
  const auto& [a, b, c] = mesh.triangles[t];
  const Eigen::Vector3f p = mesh.positions[a];
  return (mesh.positions[b] - p).cross(mesh.positions[c] - p).cast<double>().normalized();
}

/// A frame of the painted object, by casting a ray through every pixel. Knows nothing of the renderer nor of textures.
cv::Mat photograph(const Mesh& mesh, const Camera& camera, const Pose& T_camera_object, const Light& light = as_it_is,
                   const cv::Vec3b& background = {10, 10, 10}) {
  const RayCaster caster(mesh, T_camera_object);
  cv::Mat frame(camera.height, camera.width, CV_8UC3, background);
  for (int y = 0; y < frame.rows; ++y) {
    for (int x = 0; x < frame.cols; ++x) {
      const Eigen::Vector2d recorded(x, y);
      const auto hit = caster.cast(camera, camera.has_distortion() ? undistorted(camera, recorded) : recorded);
      if (hit) {
        const Eigen::Vector3d color = light(paint(point_of(mesh, *hit)), normal_of(mesh, hit->triangle));
        for (int c = 0; c < 3; ++c) {
          frame.at<cv::Vec3b>(y, x)[c] = cv::saturate_cast<std::uint8_t>(color[c]);
        }
      }
    }
  }
  return frame;
}

Pose look(double yaw, double pitch, const Eigen::Vector3d& p_camera = {0.01, -0.005, 0.42}) {
  Eigen::Matrix3d upright;  // object z up, x towards the camera
  upright << 0, 1, 0, 0, 0, -1, -1, 0, 0;
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitX()).toRotationMatrix() * upright *
                  Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.translation() = p_camera;
  return pose;
}

TextureOptions texture_options() {
  TextureOptions options;
  options.texels_per_metre = 700;
  return options;
}

/// A texel of a baked model, found by the model's texture coordinates alone.
struct Texel {
  Eigen::Vector3d p_object;
  Eigen::Vector3d normal;
  std::array<std::uint8_t, 4> rgba;
  std::size_t index;
};

/// All texels whose centre lies on the surface, off the edges of triangles.
std::vector<Texel> surface_texels(const Mesh& mesh) {
  std::vector<Texel> texels;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::size_t material = mesh.triangle_materials.empty() ? 0 : mesh.triangle_materials[t];
    const Texture& texture = mesh.materials[material].texture;
    Eigen::Matrix3d corners;  // columns: x, y in texels, 1
    Eigen::Matrix3d positions;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t vertex = mesh.triangles[t][static_cast<std::size_t>(k)];
      const Eigen::Vector2d coordinate = mesh.texture_coordinates[vertex].cast<double>();
      corners.col(k) =
          Eigen::Vector3d(coordinate.x() * texture.width - 0.5, (1 - coordinate.y()) * texture.height - 0.5, 1);
      positions.col(k) = mesh.positions[vertex].cast<double>();
    }
    const Eigen::Matrix3d weights_of = corners.inverse();
    for (int y = 0; y < texture.height; ++y) {
      for (int x = 0; x < texture.width; ++x) {
        const Eigen::Vector3d weights = weights_of * Eigen::Vector3d(x, y, 1);
        if (weights.minCoeff() > 1e-4) {
          const std::size_t index = static_cast<std::size_t>(y) * texture.width + x;
          const std::uint8_t* rgba = texture.rgba.data() + 4 * index;
          texels.push_back({positions * weights, normal_of(mesh, t), {rgba[0], rgba[1], rgba[2], rgba[3]}, index});
        }
      }
    }
  }
  return texels;
}

double error_of_texel(const Texel& texel) {
  const Eigen::Vector3d truth = paint(texel.p_object);
  double largest = 0;
  for (int c = 0; c < 3; ++c) {
    largest = std::max(largest, std::abs(texel.rgba[static_cast<std::size_t>(2 - c)] - truth[c]));
  }
  return largest;
}

/// Does the camera see this point of the surface, and nothing else but its surroundings within `radius` pixels?
enum class Sight { hidden, near_border, clear };

Sight sight_of(const RayCaster& caster, const Camera& camera, const Pose& T_camera_object, const Texel& texel,
               double radius) {
  const Eigen::Vector3d p_camera = T_camera_object * texel.p_object;
  const Eigen::Vector2d pixel = camera.project(p_camera);
  const auto hit = caster.cast(camera, pixel);
  if (!hit || std::abs(hit->depth - p_camera.z()) > 1e-4) {
    return Sight::hidden;
  }
  if (pixel.x() < radius || pixel.y() < radius || pixel.x() > camera.width - 1 - radius ||
      pixel.y() > camera.height - 1 - radius) {
    return Sight::near_border;
  }
  for (int k = 0; k < 16; ++k) {
    const double angle = k * std::numbers::pi / 8;
    for (const double share : {0.5, 1.0}) {
      const auto near = caster.cast(camera, pixel + share * radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
      if (!near || std::abs(near->depth - p_camera.z()) > 0.05 * p_camera.z()) {
        return Sight::near_border;
      }
    }
  }
  return Sight::clear;
}

double cosine_of(const Pose& T_camera_object, const Texel& texel) {
  const Eigen::Vector3d p_camera = T_camera_object * texel.p_object;
  return -(T_camera_object.linear() * texel.normal).dot(p_camera.normalized());
}

/// A frame baked from nothing, judged texel by texel.
struct Verdict {
  long known = 0;
  long known_though_hidden = 0;
  long known_though_near_border = 0;
  long unknown_though_clear = 0;
  long clear = 0;
  double largest_error = 0;  // of known texels, levels
};

Verdict judge(const Mesh& baked, const Mesh& shape, const Camera& camera, const Pose& T_camera_object,
              const BakeOptions& options) {
  Verdict verdict;
  const RayCaster caster(shape, T_camera_object);
  for (const Texel& texel : surface_texels(baked)) {
    const bool known = texel.rgba[3] != 0;
    const Sight sight = sight_of(caster, camera, T_camera_object, texel, options.margin + 2);
    verdict.known += known ? 1 : 0;
    verdict.known_though_hidden += known && sight == Sight::hidden ? 1 : 0;
    if (known && sight == Sight::near_border) {
      const Sight closer = sight_of(caster, camera, T_camera_object, texel, options.margin - 1.5);
      verdict.known_though_near_border += closer == Sight::near_border ? 1 : 0;
    }
    if (sight == Sight::clear && cosine_of(T_camera_object, texel) > options.least_cosine + 0.02) {
      ++verdict.clear;
      verdict.unknown_though_clear += known ? 0 : 1;
    }
    if (known) {
      verdict.largest_error = std::max(verdict.largest_error, error_of_texel(texel));
    }
  }
  return verdict;
}

/// Paint is sampled at pixels and interpolated: foreshortened to a quarter, its shortest wave (78 mm) is 15 pixels
/// long, which costs 70 (2 pi / 15)^2 / 8 = 1.5 levels; rounding to 8 bits twice adds 1.
constexpr double kPaintError = 2.5;

void check(const Verdict& verdict) {
  CHECK(verdict.clear > 3000);
  CHECK(verdict.known_though_hidden == 0);
  CHECK(verdict.known_though_near_border == 0);
  CHECK(verdict.unknown_though_clear == 0);
  CHECK(verdict.largest_error < kPaintError);
}

}  // namespace

TEST_CASE("One frame: what it shows is known and right, what it does not show is unknown") {
  const Mesh shape = one_box();
  const Pose pose = look(0.5, 0.6);
  const BakeOptions options;
  TextureBaker baker = make_baker(shape, kCamera, pose, texture_options(), options);
  CHECK(baker.coverage() == 0);
  const FrameUse use = baker.add_frame(photograph(shape, kCamera, pose), pose, PoseSource::given);
  CHECK(use.taken);
  check(judge(baker.model(), shape, kCamera, pose, options));
  // Three of six faces, less their margin: coverage is a share of the surface.
  long known = 0;
  const std::vector<Texel> texels = surface_texels(baker.model());
  for (const Texel& texel : texels) {
    known += texel.rgba[3] != 0 ? 1 : 0;
  }
  CHECK(baker.coverage() ==
        doctest::Approx(static_cast<double>(known) / static_cast<double>(texels.size())).epsilon(0.01));
  CHECK(baker.coverage() > 0.35);
  CHECK(baker.coverage() < 0.5);
}

TEST_CASE("What the object itself hides stays unknown") {
  const Mesh shape = two_boxes();
  const Pose pose = look(0.15, 0.2, {0, 0, 0.36});
  const BakeOptions options;
  TextureBaker baker = make_baker(shape, kCamera, pose, texture_options(), options);
  baker.add_frame(photograph(shape, kCamera, pose), pose, PoseSource::given);
  const Mesh baked = baker.model();
  check(judge(baked, shape, kCamera, pose, options));
  // There is such surface: of the large box's face x+, behind the small one.
  const RayCaster caster(shape, pose);
  long hidden = 0;
  for (const Texel& texel : surface_texels(baked)) {
    const bool on_large_face = texel.normal.x() > 0.9 && texel.p_object.x() < 0.05;
    hidden += on_large_face && sight_of(caster, kCamera, pose, texel, 1) == Sight::hidden ? 1 : 0;
  }
  CHECK(hidden > 300);
}

TEST_CASE("Inside-out, open and unclosed meshes are baked from the side that is seen") {
  const Pose pose = look(0.5, 0.6);
  const BakeOptions options;
  SUBCASE("wound inwards") {
    Mesh shape = one_box();
    for (auto& triangle : shape.triangles) {
      std::swap(triangle[0], triangle[1]);
    }
    TextureBaker baker = make_baker(shape, kCamera, pose, texture_options(), options);
    baker.add_frame(photograph(shape, kCamera, pose), pose, PoseSource::given);
    CHECK(baker.coverage() > 0.35);
    CHECK(baker.coverage() < 0.5);
  }
  SUBCASE("a plate of one side") {
    Mesh plate;
    plate.positions = {{0, -0.06F, -0.05F}, {0, 0.06F, -0.05F}, {0, 0.06F, 0.05F}, {0, -0.06F, 0.05F}};
    plate.triangles = {{0, 2, 1}, {0, 3, 2}};  // its back is to the camera
    TextureBaker baker = make_baker(plate, kCamera, pose, texture_options(), options);
    baker.add_frame(photograph(plate, kCamera, pose), pose, PoseSource::given);
    CHECK(baker.coverage() > 0.65);  // all but the margin
  }
}

TEST_CASE("Frames are looked up where the lens puts the surface") {
  Camera camera = kCamera;
  camera.distortion = {-0.25, 0.08, 0.001, -0.002, 0, 0, 0, 0};
  const Mesh shape = one_box();
  const Pose pose = look(0.5, 0.6, {0.06, 0.04, 0.42});
  const Eigen::Vector2d corner = kCamera.project(pose * Eigen::Vector3d(0.08, 0.06, 0.05));
  REQUIRE((camera.distort(corner) - corner).norm() > 1.5);  // it matters
  TextureBaker baker = make_baker(shape, camera, pose, texture_options(), {});
  baker.add_frame(photograph(shape, camera, pose), pose, PoseSource::given);
  check(judge(baker.model(), shape, camera, pose, {}));
}

TEST_CASE("Surface partly outside the frame or behind the camera stays unknown") {
  const Mesh shape = one_box();
  const Pose pose = look(0.5, 0.6, {0.17, 0.02, 0.42});
  TextureBaker baker = make_baker(shape, kCamera, pose, texture_options(), {});
  baker.add_frame(photograph(shape, kCamera, pose), pose, PoseSource::given);
  const Verdict verdict = judge(baker.model(), shape, kCamera, pose, {});
  CHECK(verdict.clear > 1000);
  CHECK(verdict.known_though_hidden == 0);
  CHECK(verdict.known_though_near_border == 0);
  CHECK(verdict.unknown_though_clear == 0);
  CHECK(verdict.largest_error < kPaintError);
  const FrameUse use = baker.add_frame(photograph(shape, kCamera, pose), look(0, 0, {0, 0, -0.5}), PoseSource::given);
  CHECK_FALSE(use.taken);
}

TEST_CASE("Filtering at a chart's border meets the chart's own colour, and nothing unknown where all is known") {
  const Mesh shape = one_box();
  TextureBaker baker = make_baker(shape, kCamera, look(0.5, 0.6), texture_options(), {});
  for (int side = 0; side < 4; ++side) {
    for (const double pitch : {0.6, -0.6}) {
      const Pose pose = look(0.5 + side * std::numbers::pi / 2, pitch);
      baker.add_frame(photograph(shape, kCamera, pose), pose, PoseSource::given);
    }
  }
  CHECK(baker.coverage() > 0.999);
  const Mesh baked = baker.model();
  const Texture& texture = baked.materials[0].texture;
  std::vector<double> errors;
  for (const Texel& texel : surface_texels(baked)) {
    errors.push_back(error_of_texel(texel));
    const int x = static_cast<int>(texel.index) % texture.width;
    const int y = static_cast<int>(texel.index) / texture.width;
    for (int dy = -2; dy <= 2; ++dy) {
      for (int dx = -2; dx <= 2; ++dx) {
        const std::size_t near = static_cast<std::size_t>(y + dy) * texture.width + x + dx;
        if (texture.rgba[4 * near + 3] != 255) {
          FAIL("an unknown texel within two of a known one");
        }
        // Paint changes by less than 15 levels over three texels along the surface.
        for (std::size_t c = 0; c < 3; ++c) {
          if (std::abs(texture.rgba[4 * near + c] - texel.rgba[c]) > 25) {
            FAIL("another chart's colour within two texels");
          }
        }
      }
    }
  }
  // Eight views joined: still the paint.
  CHECK(*std::max_element(errors.begin(), errors.end()) < 3.0);
}

TEST_CASE("The best of several given views counts") {
  const Mesh shape = one_box();
  // The face y+ is seen flat first, then well, then flat again; only the good view shows its paint.
  const Pose flat_view = look(0.3, 0.5);
  const Pose good_view = look(-1.2, 0.5);
  const auto false_color = [](const Eigen::Vector3d& color, const Eigen::Vector3d& normal) {
    return normal.y() < -0.9 || normal.y() > 0.9 ? Eigen::Vector3d(250, 0, 250) : color;
  };
  for (const bool flat_first : {true, false}) {
    CAPTURE(flat_first);
    TextureBaker baker = make_baker(shape, kCamera, flat_view, texture_options(), {});
    const cv::Mat flat_frame = photograph(shape, kCamera, flat_view, false_color);
    const cv::Mat good_frame = photograph(shape, kCamera, good_view);
    if (flat_first) {
      baker.add_frame(flat_frame, flat_view, PoseSource::given);
    }
    baker.add_frame(good_frame, good_view, PoseSource::given);
    baker.add_frame(flat_frame, flat_view, PoseSource::given);
    const Mesh baked = baker.model();
    const RayCaster caster(shape, good_view);
    long compared = 0;
    long wrong = 0;
    for (const Texel& texel : surface_texels(baked)) {
      if (std::abs(texel.normal.y()) > 0.9 && sight_of(caster, kCamera, good_view, texel, 7) == Sight::clear) {
        ++compared;
        wrong += error_of_texel(texel) > 12 ? 1 : 0;
      }
    }
    CHECK(compared > 2000);
    CHECK(wrong == 0);
  }
}

TEST_CASE("Tracked frames never touch what a given pose brought; right after it they even out its noise") {
  const Mesh shape = one_box();
  const Pose first = look(0.5, 0.6);
  cv::Mat noise(kCamera.height, kCamera.width, CV_16SC3);
  cv::RNG random(5);
  const auto noisy = [&](const Pose& pose) {
    random.fill(noise, cv::RNG::NORMAL, 0, 6);
    cv::Mat frame = photograph(shape, kCamera, pose);
    cv::add(frame, noise, frame, cv::noArray(), CV_8UC3);
    return frame;
  };
  TextureBaker baker = make_baker(shape, kCamera, first, texture_options(), {});
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

namespace completing {

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
  TextureBaker baker = make_baker(shape, kCamera, turned(-0.4), texture_options(), {});
  baker.add_frame(photograph(shape, kCamera, turned(-0.4)), turned(-0.4), PoseSource::given);
  REQUIRE(new_face(baker).known == 0);
  return baker;
}

}  // namespace completing

TEST_CASE("What turns into view is taken once two frames between which the object moved agree") {
  using namespace completing;
  const Mesh shape = one_box();
  TextureBaker baker = started(shape);
  const auto add = [&](double angle) {
    return baker.add_frame(photograph(shape, kCamera, turned(angle)), turned(angle), PoseSource::tracked);
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
  using namespace completing;
  const Mesh shape = one_box();
  TextureBaker baker = started(shape);
  SUBCASE("background, where the object is smaller than its model") {
    Mesh real;  // stands back by 40 mm in the lower third of the new face
    add_box(real, {0, 0, 0.015F}, {0.16F, 0.12F, 0.07F});
    add_box(real, {0, 0.02F, -0.035F}, {0.16F, 0.08F, 0.03F});
    for (const double angle : {0.4, 0.46, 0.52}) {
      const auto level = static_cast<std::uint8_t>(2500 * (angle - 0.4) / 3 + 40);
      const cv::Mat frame = photograph(real, kCamera, turned(angle), as_it_is, {level, level, level});
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
      cv::Mat frame = photograph(shape, kCamera, turned(angle));
      // It lies on the edge from the top face down to the new one, and moves with the box.
      const Eigen::Vector2d tip = kCamera.project(turned(angle) * Eigen::Vector3d(0.03, -0.06, 0.05));
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
    cv::Mat other(kCamera.height, kCamera.width, CV_8UC3);
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

TEST_CASE("Exposure, white balance and shading by the light are evened out") {
  const Mesh shape = one_box();
  const Pose first = look(0.25, 0.55);
  TextureBaker baker = make_baker(shape, kCamera, first, texture_options(), {});
  baker.add_frame(photograph(shape, kCamera, first), first, PoseSource::given);
  // Another camera setting, and the light from another side: the two faces known already differ by 30 %.
  const Pose second = look(-0.4, 0.55);
  const auto light = [](const Eigen::Vector3d& color, const Eigen::Vector3d& normal) {
    const double shading = 0.7 + 0.25 * normal.x() + 0.1 * normal.z();
    return Eigen::Vector3d(shading * color.cwiseProduct(Eigen::Vector3d(0.8, 0.9, 1.0)) + Eigen::Vector3d(6, 4, 0));
  };
  baker.add_frame(photograph(shape, kCamera, second, light), second, PoseSource::given);
  // Faces x+ and z+ were known; what the second frame adds to them (their borders) has the paint's own colours.
  long known = 0;
  double largest = 0;
  for (const Texel& texel : surface_texels(baker.model())) {
    if (texel.rgba[3] != 0 && (texel.normal.x() > 0.9 || texel.normal.z() > 0.9)) {
      ++known;
      largest = std::max(largest, error_of_texel(texel));
    }
  }
  CHECK(known > 5000);
  CHECK(largest < 7);
}

TEST_CASE("The photometric match is found among a quarter of outliers, and is nothing without pairs") {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> level(20, 200);
  std::normal_distribution<float> noise(0, 3);
  std::vector<ColorPair> pairs;
  const Eigen::Vector3f shading(0.15F, -0.1F, 0.05F);
  for (int i = 0; i < 2000; ++i) {
    ColorPair pair;
    pair.normal = Eigen::Vector3f::Random().normalized();
    for (std::size_t c = 0; c < 3; ++c) {
      pair.texture[c] = level(random);
      const float gain = 0.8F + shading.dot(pair.normal);
      pair.frame[c] = i % 4 == 0 ? level(random) : gain * pair.texture[c] + 12 + noise(random);
    }
    pairs.push_back(pair);
  }
  const PhotometricMatch match = match_photometry(pairs, 20);
  double worst = 0;
  for (const ColorPair& pair : pairs) {
    const float gain = 0.8F + shading.dot(pair.normal);
    const ColorF shown{gain * 100 + 12, gain * 100 + 12, gain * 100 + 12};
    for (const float back : match.to_texture(shown, pair.normal)) {
      worst = std::max<double>(worst, std::abs(back - 100));
    }
  }
  CHECK(worst < 2.5);

  pairs.resize(50);
  const ColorF same = match_photometry(pairs, 20).to_texture({40, 50, 60}, Eigen::Vector3f::UnitX());
  CHECK(same == ColorF{40, 50, 60});
}

TEST_CASE("A mesh with texture coordinates keeps them, each material its own texture") {
  Mesh mesh = simulation::textured_box();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {  // a second material for the second half
    mesh.triangle_materials.push_back(t < mesh.triangles.size() / 2 ? 0 : 1);
  }
  mesh.materials.push_back({"second", mesh.materials[0].texture});
  const Pose pose = look(0.5, 0.6);
  TextureBaker baker = make_baker(mesh, kCamera, pose, texture_options(), {});
  baker.add_frame(photograph(mesh, kCamera, pose), pose, PoseSource::given);
  const Mesh baked = baker.model();
  CHECK(baked.texture_coordinates == mesh.texture_coordinates);
  CHECK(baked.triangles == mesh.triangles);
  REQUIRE(baked.materials.size() == 2);
  long known = 0;
  double largest = 0;
  for (const Texel& texel : surface_texels(baked)) {
    if (texel.rgba[3] != 0) {
      ++known;
      largest = std::max(largest, error_of_texel(texel));
    }
  }
  CHECK(known > 3000);
  CHECK(largest < 2 * kPaintError);  // of these texels, some are two pixels wide

  Mesh repeating = mesh;
  repeating.texture_coordinates[0].x() = 1.7F;
  CHECK(error_of([&] {
          make_baker(repeating, kCamera, pose, texture_options(), {});
        }).says(ErrorCode::model, {"texture coordinates", "--unwrap"}));
}

TEST_CASE("What a model's texture knows already is kept, and completed") {
  const Mesh shape = one_box();
  const Pose first = look(0.5, 0.6);
  TextureBaker begun = make_baker(shape, kCamera, first, texture_options(), {});
  begun.add_frame(photograph(shape, kCamera, first), first, PoseSource::given);
  const Mesh model = begun.model();

  TextureOptions keep = texture_options();
  keep.keep = true;
  TextureBaker baker = make_baker(model, kCamera, first, keep, {});
  CHECK(baker.coverage() == doctest::Approx(begun.coverage()));
  const Pose second = look(0.5 + std::numbers::pi, 0.6);
  baker.add_frame(photograph(shape, kCamera, second), second, PoseSource::given);
  CHECK(baker.coverage() > begun.coverage() + 0.2);
  const Texture& before = model.materials[0].texture;
  const Mesh completed = baker.model();
  const Texture& after = completed.materials[0].texture;
  REQUIRE(after.rgba.size() == before.rgba.size());
  for (const Texel& texel : surface_texels(model)) {
    if (texel.rgba[3] != 0 && !std::equal(texel.rgba.begin(), texel.rgba.end(),
                                          after.rgba.begin() + 4 * static_cast<std::ptrdiff_t>(texel.index))) {
      FAIL("a texel that was known has changed");
    }
  }
}

TEST_CASE("Frames of another size or format are refused") {
  TextureBaker baker = make_baker(one_box(), kCamera, look(0.5, 0.6), texture_options(), {});
  const cv::Mat small(120, 160, CV_8UC3);
  CHECK(error_of([&] {
          baker.add_frame(small, look(0, 0), PoseSource::given);
        }).says(ErrorCode::image, {"160x120", "320x240"}));
  const cv::Mat grey(240, 320, CV_8U);
  CHECK(error_of([&] { baker.add_frame(grey, look(0, 0), PoseSource::given); }).says(ErrorCode::image, {"BGR8"}));
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
    const FrameResult result = tracker.track({frame.data, frame.cols, frame.rows, frame.step[0], PixelFormat::bgr8});
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
