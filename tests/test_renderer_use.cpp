// How the renderer is used: parts of a view, strides, threads, several at a time, and what is refused.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "holdfast/error.hpp"
#include "support/allocation_counter.hpp"
#include "support/files.hpp"
#include "support/render_comparison.hpp"

namespace holdfast {
namespace {

using namespace test;

ErrorCode code_of(const auto& action) {
  try {
    action();
  } catch (const Error& error) {
    CHECK(std::string(error.what()).find('\n') == std::string::npos);
    return error.code();
  }
  FAIL("no error was thrown");
  return ErrorCode::file;
}

}  // namespace

TEST_CASE("A region of the view, also partly or wholly outside the frame, is that part of the view") {
  const Mesh mesh = colored_box();
  Renderer renderer(mesh, 160, 130);
  const Pose pose = pose_at({-0.10, 0.03, 0.42}, {0.4, 0.9, -0.3});
  for (const Rect& roi : {Rect{11, 23, 67, 45}, Rect{-31, -17, 97, 88}, Rect{100, 60, 77, 69}, Rect{-45, 20, 41, 64},
                          Rect{30, 40, 1, 1}}) {
    CAPTURE(roi.x);
    const Comparison comparison = compare(mesh, pose, kRenderCamera, draw(renderer, pose, kRenderCamera, roi));
    check_geometry(comparison);
    CHECK(comparison.color_error <= 2);
    if (roi.x != 100) {
      CHECK(comparison.surface_pixels > 0);
    }
  }
}

TEST_CASE("Rows are written at the target's stride and nothing between them is touched; either buffer may be absent") {
  const Mesh mesh = colored_box();
  Renderer renderer(mesh, kRenderCamera.width, kRenderCamera.height);
  const Pose pose = pose_at({0, 0, 0.5}, {0.4, 0.9, -0.3});
  const Rect roi{20, 10, 83, 71};
  const View packed = draw(renderer, pose, kRenderCamera, roi);
  const int stride = 96;
  for (const bool in_front : {true, false}) {
    std::vector<std::uint8_t> rgba(static_cast<std::size_t>(stride) * roi.height * 4, 77);
    std::vector<float> depth(static_cast<std::size_t>(stride) * roi.height, -7.0F);
    renderer.render(in_front ? pose : pose_at({0, 0, -0.5}), kRenderCamera, roi, {rgba.data(), depth.data(), stride});
    long wrong = 0;
    for (int row = 0; row < roi.height; ++row) {
      for (int column = 0; column < stride; ++column) {
        const std::size_t i = static_cast<std::size_t>(row) * stride + column;
        if (column >= roi.width) {
          wrong += rgba[4 * i] == 77 && rgba[4 * i + 3] == 77 && depth[i] == -7.0F ? 0 : 1;
        } else if (in_front) {
          wrong += std::equal(&rgba[4 * i], &rgba[4 * i] + 4, packed.pixel(column, row)) ? 0 : 1;
          wrong += depth[i] == packed.window_depth[packed.index(column, row)] ? 0 : 1;
        } else {
          wrong += rgba[4 * i] == 0 && rgba[4 * i + 3] == 0 && depth[i] == 1.0F ? 0 : 1;
        }
      }
    }
    CHECK(wrong == 0);
  }
  std::vector<std::uint8_t> rgba(packed.rgba.size());
  std::vector<float> depth(packed.window_depth.size());
  renderer.render(pose, kRenderCamera, roi, {rgba.data(), nullptr, 0});
  renderer.render(pose, kRenderCamera, roi, {nullptr, depth.data(), 0});
  CHECK(rgba == packed.rgba);
  CHECK(depth == packed.window_depth);
}

TEST_CASE("Two renderers live beside each other, and the end of one leaves the other alone") {
  const Mesh mesh = colored_box();
  const Mesh other_mesh = quad(random_texture(8, 8, 3));
  const Pose pose = pose_at({0, 0, 0.5}, {0.4, 0.9, -0.3});
  auto first = std::make_unique<Renderer>(mesh, kRenderCamera.width, kRenderCamera.height);
  const View alone = draw(*first, pose, kRenderCamera);
  CHECK(alone.drawn_count() > 500);

  auto second = std::make_unique<Renderer>(other_mesh, kRenderCamera.width, kRenderCamera.height);
  const View other = draw(*second, pose, kRenderCamera);
  CHECK(other.window_depth != alone.window_depth);
  const View between = draw(*first, pose, kRenderCamera);
  CHECK(between.rgba == alone.rgba);
  CHECK(between.window_depth == alone.window_depth);

  second.reset();
  const View after = draw(*first, pose, kRenderCamera);
  CHECK(after.rgba == alone.rgba);
  CHECK(after.window_depth == alone.window_depth);

  second = std::make_unique<Renderer>(other_mesh, kRenderCamera.width, kRenderCamera.height);
  first.reset();
  const View survivor = draw(*second, pose, kRenderCamera);
  CHECK(survivor.rgba == other.rgba);
}

TEST_CASE("A renderer works from any thread, and several threads may each use their own") {
  const Mesh mesh = colored_box();
  const Pose pose = pose_at({0, 0, 0.5}, {0.4, 0.9, -0.3});
  auto renderer = std::make_unique<Renderer>(mesh, kRenderCamera.width, kRenderCamera.height);
  const View here = draw(*renderer, pose, kRenderCamera);
  View there;
  std::thread([&] { there = draw(*renderer, pose, kRenderCamera); }).join();
  CHECK(there.rgba == here.rgba);
  CHECK(there.window_depth == here.window_depth);
  const View back = draw(*renderer, pose, kRenderCamera);
  CHECK(back.rgba == here.rgba);

  std::atomic<int> wrong{0};
  const auto work = [&] {
    Renderer own(mesh, kRenderCamera.width, kRenderCamera.height);
    for (int i = 0; i < 20; ++i) {
      wrong += draw(own, pose, kRenderCamera).rgba == here.rgba ? 0 : 1;
    }
  };
  std::thread one(work);
  std::thread two(work);
  one.join();
  two.join();
  CHECK(wrong == 0);

  std::thread([&] { renderer.reset(); }).join();
  Renderer later(mesh, kRenderCamera.width, kRenderCamera.height);
  CHECK(draw(later, pose, kRenderCamera).rgba == here.rgba);
}

TEST_CASE("A texture can be replaced by one of the same or another size, taken away and given back") {
  Mesh mesh = quad(random_texture(8, 8, 1));
  Renderer renderer(mesh, kRenderCamera.width, kRenderCamera.height);
  const Pose pose = pose_at({0, 0, 0.5}, {0.2, 0.3, 0.1});
  for (const Texture& texture :
       {random_texture(8, 8, 2), random_texture(5, 13, 3), Texture{}, random_texture(6, 6, 4)}) {
    renderer.set_texture(0, texture);
    mesh.materials[0].texture = texture;
    const Comparison comparison = compare(mesh, pose, kRenderCamera, draw(renderer, pose));
    check_geometry(comparison);
    CHECK(comparison.surface_pixels > 500);
    CHECK(comparison.colors == (texture.empty() ? 0 : comparison.surface_pixels));
    CHECK(comparison.color_error <= 2);
  }
}

TEST_CASE("The same view twice has the same bits, and drawing it allocates nothing") {
  const Mesh mesh = colored_box();
  Renderer renderer(mesh, 640, 480);
  const Camera camera{640, 480, 700, 710, 310, 250, {}};
  const std::array<Rect, 3> rois = {Rect{0, 0, 640, 480}, Rect{200, 150, 200, 130}, Rect{300, 200, 60, 50}};
  const std::array<Pose, 2> poses = {pose_at({0, 0, 0.5}, {0.4, 0.9, -0.3}), pose_at({0, 0, -0.5})};
  std::vector<std::uint8_t> rgba(640 * 480 * 4);
  std::vector<float> depth(640 * 480);
  for (const Rect& roi : rois) {
    renderer.render(poses[0], camera, roi, {rgba.data(), depth.data(), 640});
  }
  const long before = operator_new_count();
  for (int i = 0; i < 10; ++i) {
    for (const Rect& roi : rois) {
      for (const Pose& pose : poses) {
        renderer.render(pose, camera, roi, {rgba.data(), depth.data(), 640});
      }
    }
  }
  CHECK(operator_new_count() == before);

  const View one = draw(renderer, poses[0], camera, rois[0]);
  const View two = draw(renderer, poses[0], camera, rois[0]);
  CHECK(one.rgba == two.rgba);
  CHECK(one.window_depth == two.window_depth);
}

TEST_CASE("The first frame does not pay for compiling: construction has drawn once") {
  const Mesh mesh = colored_box();
  Renderer renderer(mesh, 64, 64);
  std::vector<std::uint8_t> rgba(64 * 64 * 4);
  std::vector<float> depth(64 * 64);
  const Camera camera{64, 64, 80, 80, 31, 31, {}};
  const long before = operator_new_count();
  renderer.render(pose_at({0, 0, 0.5}), camera, {0, 0, 64, 64}, {rgba.data(), depth.data(), 64});
  CHECK(operator_new_count() == before);
}

TEST_CASE("Misuse is an error with its code") {
  const Mesh mesh = colored_box();
  Renderer renderer(mesh, 100, 80);
  std::vector<std::uint8_t> rgba(200 * 200 * 4);
  std::vector<float> depth(200 * 200);
  const RenderTarget target{rgba.data(), depth.data(), 0};
  const Pose pose = pose_at({0, 0, 0.5});
  CHECK(code_of([&] { renderer.render(pose, kRenderCamera, {0, 0, 101, 80}, target); }) == ErrorCode::invalid_argument);
  CHECK(code_of([&] { renderer.render(pose, kRenderCamera, {0, 0, 100, 81}, target); }) == ErrorCode::invalid_argument);
  CHECK(code_of([&] { renderer.render(pose, kRenderCamera, {0, 0, 0, 10}, target); }) == ErrorCode::invalid_argument);
  CHECK(code_of([&] {
          renderer.render(pose, kRenderCamera, {0, 0, 50, 50}, {rgba.data(), depth.data(), 49});
        }) == ErrorCode::invalid_argument);
  Pose broken = pose;
  broken.translation().x() = std::nan("");
  CHECK(code_of([&] { renderer.render(broken, kRenderCamera, {0, 0, 50, 50}, target); }) == ErrorCode::pose);

  CHECK(code_of([&] { renderer.set_texture(3, random_texture(4, 4, 1)); }) == ErrorCode::invalid_argument);
  Texture short_texture = random_texture(4, 4, 1);
  short_texture.rgba.pop_back();
  CHECK(code_of([&] { renderer.set_texture(0, short_texture); }) == ErrorCode::invalid_argument);
  Texture negative = random_texture(4, 4, 1);
  negative.width = negative.height = -4;
  CHECK(code_of([&] { renderer.set_texture(0, negative); }) == ErrorCode::invalid_argument);
  CHECK(code_of([&] { renderer.set_texture(0, random_texture(1 << 17, 1, 1)); }) == ErrorCode::model);
  CHECK(draw(renderer, pose, kRenderCamera, {20, 20, 64, 64}).known_count() > 500);

  CHECK(code_of([] { Renderer(Mesh{}, 64, 64); }) == ErrorCode::model);
  CHECK(code_of([] { Renderer(quad(random_texture(1 << 17, 1, 1)), 64, 64); }) == ErrorCode::model);
  CHECK(code_of([&] { Renderer(mesh, 0, 64); }) == ErrorCode::invalid_argument);
  CHECK(code_of([&] { Renderer(mesh, 64, 64, {3}); }) == ErrorCode::invalid_argument);
  CHECK(code_of([&] { Renderer(mesh, 64, 1 << 20); }) == ErrorCode::invalid_argument);
  Mesh bare = quad({});
  bare.texture_coordinates.clear();
  Renderer bare_renderer(bare, 64, 64);
  CHECK(code_of([&] { bare_renderer.set_texture(0, random_texture(4, 4, 1)); }) == ErrorCode::invalid_argument);
}

TEST_CASE("OSMesa and EGL draw the same bits by software, and nearly the same by a graphics processor") {
  const Mesh mesh = colored_box();
  const auto renderer_by = [&](RendererChoice choice) {
    RendererOptions options;
    options.choice = choice;
    options.lit = true;
    return std::make_unique<Renderer>(mesh, kRenderCamera.width, kRenderCamera.height, options);
  };
  std::unique_ptr<Renderer> osmesa, egl;
  try {
    osmesa = renderer_by(RendererChoice::osmesa);
    egl = renderer_by(RendererChoice::egl);
  } catch (const Error& error) {
    REQUIRE(error.code() == ErrorCode::renderer);
    MESSAGE("one of them is not installed, so they are not compared: ", std::string(error.what()));
    return;
  }
  CHECK(osmesa->description().starts_with("OSMesa: "));
  CHECK(egl->description().starts_with("EGL: "));
  CHECK(osmesa->reason() == "asked for");
  const bool software = egl->description().find("llvmpipe") != std::string::npos;
  for (Renderer* renderer : {osmesa.get(), egl.get()}) renderer->set_shading({0.1, -0.2, -0.3});
  for (const Pose& pose : {pose_at({0, 0, 0.5}, {0.4, 0.9, -0.3}), pose_at({0.05, -0.02, 0.3}, {2, 0.1, 0.7})}) {
    const View one = draw(*osmesa, pose), other = draw(*egl, pose);
    REQUIRE(one.drawn_count() > 500);
    if (software) {
      CHECK(one.rgba == other.rgba);
      CHECK(one.window_depth == other.window_depth);
      continue;
    }
    long moved = 0, recolored = 0;
    for (std::size_t i = 0; i < one.window_depth.size(); ++i) {
      moved += (one.window_depth[i] < 1) != (other.window_depth[i] < 1) ? 1 : 0;
      for (std::size_t k = 4 * i; k < 4 * i + 4; ++k) {
        recolored += std::abs(one.rgba[k] - other.rgba[k]) > 3 ? 1 : 0;
      }
    }
    CHECK(moved <= one.drawn_count() / 500);  // edges' pixels
    CHECK(recolored <= one.drawn_count() / 100);
  }
}

TEST_CASE("The description names OpenGL's renderer") {
  Renderer renderer(colored_box(), 64, 64);
  CHECK((renderer.description().starts_with("OSMesa: ") || renderer.description().starts_with("EGL: ")));
  CHECK(renderer.description().find("OpenGL") != std::string::npos);
  Renderer moved = std::move(renderer);
  CHECK(draw(moved, pose_at({0, 0, 0.5}), kRenderCamera, {20, 20, 64, 64}).drawn_count() > 500);
}

}  // namespace holdfast
