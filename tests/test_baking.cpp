// Textures baked from frames with given poses, texel by texel against the paint.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <random>
#include <string>
#include <vector>

#include "baking/model_completion.hpp"
#include "baking/photometric_match.hpp"
#include "baking/texel_map.hpp"
#include "baking/texture_baker.hpp"
#include "holdfast/error.hpp"
#include "simulation/textured_box.hpp"
#include "support/files.hpp"
#include "support/painted_object.hpp"

using namespace holdfast;
using namespace holdfast::baking;
using namespace holdfast::test;

namespace {

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
  TextureBaker baker = make_baker(shape, kPhotoCamera, pose, texture_options(), options);
  CHECK(baker.coverage() == 0);
  const FrameUse use = baker.add_frame(photograph(shape, kPhotoCamera, pose), pose, PoseSource::given);
  CHECK(use.taken);
  check(judge(baker.model(), shape, kPhotoCamera, pose, options));
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
  TextureBaker baker = make_baker(shape, kPhotoCamera, pose, texture_options(), options);
  baker.add_frame(photograph(shape, kPhotoCamera, pose), pose, PoseSource::given);
  const Mesh baked = baker.model();
  check(judge(baked, shape, kPhotoCamera, pose, options));
  // There is such surface: of the large box's face x+, behind the small one.
  const RayCaster caster(shape, pose);
  long hidden = 0;
  for (const Texel& texel : surface_texels(baked)) {
    const bool on_large_face = texel.normal.x() > 0.9 && texel.p_object.x() < 0.05;
    hidden += on_large_face && sight_of(caster, kPhotoCamera, pose, texel, 1) == Sight::hidden ? 1 : 0;
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
    TextureBaker baker = make_baker(shape, kPhotoCamera, pose, texture_options(), options);
    baker.add_frame(photograph(shape, kPhotoCamera, pose), pose, PoseSource::given);
    CHECK(baker.coverage() > 0.35);
    CHECK(baker.coverage() < 0.5);
  }
  SUBCASE("a plate of one side") {
    Mesh plate;
    plate.positions = {{0, -0.06F, -0.05F}, {0, 0.06F, -0.05F}, {0, 0.06F, 0.05F}, {0, -0.06F, 0.05F}};
    plate.triangles = {{0, 2, 1}, {0, 3, 2}};  // its back is to the camera
    TextureBaker baker = make_baker(plate, kPhotoCamera, pose, texture_options(), options);
    baker.add_frame(photograph(plate, kPhotoCamera, pose), pose, PoseSource::given);
    CHECK(baker.coverage() > 0.65);  // all but the margin
  }
}

TEST_CASE("Frames are looked up where the lens puts the surface") {
  Camera camera = kPhotoCamera;
  camera.distortion = {-0.25, 0.08, 0.001, -0.002, 0, 0, 0, 0};
  const Mesh shape = one_box();
  const Pose pose = look(0.5, 0.6, {0.06, 0.04, 0.42});
  const Eigen::Vector2d corner = kPhotoCamera.project(pose * Eigen::Vector3d(0.08, 0.06, 0.05));
  REQUIRE((camera.distort(corner) - corner).norm() > 1.5);  // it matters
  TextureBaker baker = make_baker(shape, camera, pose, texture_options(), {});
  baker.add_frame(photograph(shape, camera, pose), pose, PoseSource::given);
  check(judge(baker.model(), shape, camera, pose, {}));
}

TEST_CASE("Surface partly outside the frame or behind the camera stays unknown") {
  const Mesh shape = one_box();
  const Pose pose = look(0.5, 0.6, {0.17, 0.02, 0.42});
  TextureBaker baker = make_baker(shape, kPhotoCamera, pose, texture_options(), {});
  baker.add_frame(photograph(shape, kPhotoCamera, pose), pose, PoseSource::given);
  const Verdict verdict = judge(baker.model(), shape, kPhotoCamera, pose, {});
  CHECK(verdict.clear > 1000);
  CHECK(verdict.known_though_hidden == 0);
  CHECK(verdict.known_though_near_border == 0);
  CHECK(verdict.unknown_though_clear == 0);
  CHECK(verdict.largest_error < kPaintError);
  const FrameUse use =
      baker.add_frame(photograph(shape, kPhotoCamera, pose), look(0, 0, {0, 0, -0.5}), PoseSource::given);
  CHECK_FALSE(use.taken);
}

TEST_CASE("Filtering at a chart's border meets the chart's own colour, and nothing unknown where all is known") {
  const Mesh shape = one_box();
  TextureBaker baker = make_baker(shape, kPhotoCamera, look(0.5, 0.6), texture_options(), {});
  for (int side = 0; side < 4; ++side) {
    for (const double pitch : {0.6, -0.6}) {
      const Pose pose = look(0.5 + side * std::numbers::pi / 2, pitch);
      baker.add_frame(photograph(shape, kPhotoCamera, pose), pose, PoseSource::given);
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
    TextureBaker baker = make_baker(shape, kPhotoCamera, flat_view, texture_options(), {});
    const cv::Mat flat_frame = photograph(shape, kPhotoCamera, flat_view, false_color);
    const cv::Mat good_frame = photograph(shape, kPhotoCamera, good_view);
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
      if (std::abs(texel.normal.y()) > 0.9 && sight_of(caster, kPhotoCamera, good_view, texel, 7) == Sight::clear) {
        ++compared;
        wrong += error_of_texel(texel) > 12 ? 1 : 0;
      }
    }
    CHECK(compared > 2000);
    CHECK(wrong == 0);
  }
}

TEST_CASE("Exposure, white balance and shading by the light are evened out") {
  const Mesh shape = one_box();
  const Pose first = look(0.25, 0.55);
  TextureBaker baker = make_baker(shape, kPhotoCamera, first, texture_options(), {});
  baker.add_frame(photograph(shape, kPhotoCamera, first), first, PoseSource::given);
  // Another camera setting, and the light from another side: the two faces known already differ by 30 %.
  const Pose second = look(-0.4, 0.55);
  const auto light = [](const Eigen::Vector3d& color, const Eigen::Vector3d& normal) {
    const double shading = 0.7 + 0.25 * normal.x() + 0.1 * normal.z();
    return Eigen::Vector3d(shading * color.cwiseProduct(Eigen::Vector3d(0.8, 0.9, 1.0)) + Eigen::Vector3d(6, 4, 0));
  };
  baker.add_frame(photograph(shape, kPhotoCamera, second, light), second, PoseSource::given);
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
  TextureBaker baker = make_baker(mesh, kPhotoCamera, pose, texture_options(), {});
  baker.add_frame(photograph(mesh, kPhotoCamera, pose), pose, PoseSource::given);
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
          make_baker(repeating, kPhotoCamera, pose, texture_options(), {});
        }).says(ErrorCode::model, {"texture coordinates", "--unwrap"}));
}

TEST_CASE("What a model's texture knows already is kept, and completed") {
  const Mesh shape = one_box();
  const Pose first = look(0.5, 0.6);
  TextureBaker begun = make_baker(shape, kPhotoCamera, first, texture_options(), {});
  begun.add_frame(photograph(shape, kPhotoCamera, first), first, PoseSource::given);
  const Mesh model = begun.model();

  TextureOptions keep = texture_options();
  keep.keep = true;
  TextureBaker baker = make_baker(model, kPhotoCamera, first, keep, {});
  CHECK(baker.coverage() == doctest::Approx(begun.coverage()));
  const Pose second = look(0.5 + std::numbers::pi, 0.6);
  baker.add_frame(photograph(shape, kPhotoCamera, second), second, PoseSource::given);
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
  TextureBaker baker = make_baker(one_box(), kPhotoCamera, look(0.5, 0.6), texture_options(), {});
  const cv::Mat small(120, 160, CV_8UC3);
  CHECK(error_of([&] {
          baker.add_frame(small, look(0, 0), PoseSource::given);
        }).says(ErrorCode::image, {"160x120", "320x240"}));
  const cv::Mat grey(240, 320, CV_8U);
  CHECK(error_of([&] { baker.add_frame(grey, look(0, 0), PoseSource::given); }).says(ErrorCode::image, {"BGR8"}));
}

TEST_CASE("Texels that two places of the surface share are told, those of both faces of a sheet are not") {
  Mesh mesh;
  for (const float z : {0.0F, 0.1F}) {
    for (const Eigen::Vector2f& corner : {Eigen::Vector2f(0, 0), Eigen::Vector2f(1, 0), Eigen::Vector2f(0, 1)}) {
      mesh.positions.push_back({0.1F * corner.x(), 0.1F * corner.y(), z});
      mesh.texture_coordinates.push_back(corner);
    }
  }
  mesh.triangles = {{0, 1, 2}, {2, 1, 0}};
  const auto shared = [&] {
    const std::vector<std::uint8_t> flags = map_texels(mesh, {{64, 64}}).shared;
    return std::count(flags.begin(), flags.end(), 1);
  };
  const Camera camera{64, 48, 60, 60, 31.5, 23.5, {}};
  CHECK(shared() == 0);
  CHECK_FALSE(coordinate_doubt(TextureBaker(mesh, {{64, 64}}, camera)));
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  CHECK(shared() > 1900);  // of half the texture, 2048
  const std::string doubt = coordinate_doubt(TextureBaker(mesh, {{64, 64}}, camera)).value_or("");
  CHECK(doubt.find("two or more places") != std::string::npos);
  CHECK(doubt.find("--unwrap") != std::string::npos);
}
