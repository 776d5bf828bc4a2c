// Where a lost object without texture is looked for: edges and colours of a small picture, direction by direction, and
// the poses that are proposed.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "contour/contour_modality.hpp"
#include "device/device_impl.hpp"
#include "edges/edge_modality.hpp"
#include "recovery/outline_search.hpp"
#include "support/edge_shapes.hpp"
#include "support/render_comparison.hpp"

namespace {

using namespace holdfast;

/// The tracker's usual budget of a frame.
constexpr double kBudgetMs = 25;

/// A picture of four floats a pixel: a bright square from `first` to `last` in the dark, and what says so.
struct Square {
  static constexpr int kWidth = 48, kHeight = 40, kFirst = 12, kLast = 27;
  Square() : rgb(4 * kWidth * kHeight, 0.2F), says(kWidth * kHeight, -1.0F) {
    for (int y = kFirst; y <= kLast; ++y) {
      for (int x = kFirst; x <= kLast; ++x) {
        std::fill_n(rgb.begin() + 4 * (y * kWidth + x), 3, 0.8F);
        says[static_cast<std::size_t>(y * kWidth + x)] = 1;
      }
    }
  }
  std::vector<float> rgb, says;
};

/// Two blocks side by side, one of them half as high: no turn maps them onto themselves.
Mesh step_shape() {
  Mesh mesh = test::block({0.12F, 0.08F, 0.05F});
  Mesh step = test::block({0.05F, 0.05F, 0.05F});
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Eigen::Vector3f& p : step.positions) mesh.positions.push_back(p + Eigen::Vector3f(0.035F, 0.015F, 0.05F));
  for (auto triangle : step.triangles) {
    for (auto& corner : triangle) corner += first;
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

const Camera kCamera{320, 240, 300, 300, 159.5, 119.5, {}};

struct Scene {
  explicit Scene(const Device& device)
      : mesh(step_shape()),
        filter(device.impl()),
        view(device.impl(), mesh, view_renderer(mesh, levels, {}), levels, filter),
        image(device.impl(), kCamera, levels, filter),
        extent{mesh.center().cast<double>(), mesh.radius()},
        shape(levels, extent, view),
        contour(device.impl(), levels, extent, view, shape, image),
        edges(device.impl(), levels, extent, mesh, shape, image),
        search(device.impl(), levels, extent, edges.samples(), image, shape) {}

  /// A frame of the object in one colour, before another with bars of the object's across it.
  void show(const Pose& T) {
    Renderer renderer(mesh, kCamera.width, kCamera.height);
    const test::View drawn = test::draw(renderer, T, kCamera);
    rgba.assign(static_cast<std::size_t>(4 * kCamera.width * kCamera.height), 255);
    for (int y = 0; y < kCamera.height; ++y) {
      for (int x = 0; x < kCamera.width; ++x) {
        const bool object = drawn.drawn(x, y) || (x > 250 && x < 262) || (y > 190 && y < 199);
        std::uint8_t* pixel = rgba.data() + 4 * (y * kCamera.width + x);
        pixel[0] = object ? 200 : 60;
        pixel[1] = object ? 90 : 110;
        pixel[2] = object ? 40 : 170;
      }
    }
    image.enqueue_upload(ImageView{rgba.data(), kCamera.width, kCamera.height, 0, PixelFormat::rgba8},
                         image.region({0, 0, kCamera.width, kCamera.height}));
    image.wait_for_upload();
    shape.start_frame();
  }

  /// The colours of both sides in a frame of the object at this pose.
  ColorHistograms colors_at(const Pose& T) {
    show(T);
    ColorHistograms colors;
    REQUIRE(contour.learn(T, 0, colors));
    return colors;
  }

  /// The least nearest() of the poses that a new search proposes in so many frames.
  double nearest_within(int frames, const Pose& T_last, const Pose& T_true, const ColorHistograms& colors,
                        bool all_sides) {
    search.end();
    double least = 1e9;
    for (int frame = 0; frame < frames; ++frame) {
      least = std::min(least, nearest(T_true, search.starts(T_last, colors, kBudgetMs, all_sides)));
    }
    return least;
  }

  /// The least turn and distance from the truth of the poses proposed, radians and object radii, added up.
  double nearest(const Pose& T_true, const std::vector<Pose>& poses) const {
    double least = 1e9;
    for (const Pose& T : poses) {
      const Eigen::Vector3d apart = T * extent.p_object_center - T_true * extent.p_object_center;
      least = std::min(least, rotation_angle(T.linear().transpose() * T_true.linear()) + apart.norm() / extent.radius);
    }
    return least;
  }

  Mesh mesh;
  std::vector<Level> levels = make_levels(kCamera, 3);
  ImageFilter filter;
  ViewTemplate view;
  DeviceImage image;
  Extent extent;
  DepthView shape;
  ContourModality contour;
  EdgeModality edges;
  OutlineSearch search;
  std::vector<std::uint8_t> rgba;
};

Pose pose_of(const Eigen::Vector3d& turn, const Eigen::Vector3d& place) {
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  T.translation() = place;
  return T;
}

}  // namespace

TEST_CASE("directions go around in sixteenths; those of edges are half of them") {
  CHECK(DirectionResponses::direction(1, 0) == 0);
  CHECK(DirectionResponses::direction(0, 1) == 4);
  CHECK(DirectionResponses::direction(-1, 0.01) == 8);
  CHECK(DirectionResponses::direction(-1, -0.01) == 8);
  CHECK(DirectionResponses::direction(0, -1) == 12);
  CHECK(DirectionResponses::direction(1, 1) == 2);
}

TEST_CASE("an edge answers to its own direction, less to the next, and a contour to the object's side") {
  const Square square;
  DirectionResponses responses;
  constexpr int kMargin = 6;
  responses.compute(square.rgb.data(), Square::kWidth, square.says, Square::kWidth, Square::kHeight, kMargin);
  const int middle = (Square::kFirst + Square::kLast) / 2;
  const auto edge = [&](int direction, int x, int y) {
    return static_cast<int>(*responses.edges(direction, x + kMargin, y + kMargin));
  };
  const auto contour = [&](int direction, int x, int y) {
    return static_cast<int>(*responses.contours(direction, x + kMargin, y + kMargin));
  };
  // Three pixels see a lone edge, of the thirteen around it that are averaged.
  const int alone = DirectionResponses::kNothing + (255 - DirectionResponses::kNothing) * 10 / 13;
  for (const int x : {Square::kFirst, Square::kLast}) {  // upright edges, normals along x
    CAPTURE(x);
    CHECK(std::abs(edge(0, x, middle) - alone) <= 1);
    CHECK(edge(1, x, middle) < edge(0, x, middle));
    CHECK(edge(1, x, middle) > DirectionResponses::kNothing);
    CHECK(edge(4, x, middle) < DirectionResponses::kNothing);
    const int out = x == Square::kLast ? 0 : 8, in = 8 - out;
    CHECK(contour(out, x, middle) > alone);
    CHECK(contour(in, x, middle) < contour(out, x, middle) - 60);
  }
  CHECK(std::abs(edge(4, middle, Square::kFirst) - alone) <= 1);
  CHECK(contour(12, middle, Square::kFirst) > alone);
  CHECK(contour(4, middle, Square::kLast) > alone);
  for (int d = 0; d < DirectionResponses::kEdges; ++d) {
    CHECK(edge(d, middle, middle) <= DirectionResponses::kNothing);
    CHECK(edge(d, middle, middle) > DirectionResponses::kNothing - 5);
    CHECK(edge(d, -3, middle) == DirectionResponses::kNothing);
    CHECK(edge(d, Square::kWidth + 2, Square::kHeight + 2) == DirectionResponses::kNothing);
  }
}

TEST_CASE("an edge among many of its direction says next to nothing") {
  constexpr int kMargin = 2;
  std::vector<float> rgb(4 * Square::kWidth * Square::kHeight);
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = i / 4 % Square::kWidth / 3 % 2 == 0 ? 0.2F : 0.8F;
  DirectionResponses responses;
  responses.compute(rgb.data(), Square::kWidth, std::vector<float>(rgb.size() / 4, 0.0F), Square::kWidth,
                    Square::kHeight, kMargin);
  for (int x = 12; x < 36; ++x) {
    CAPTURE(x);
    CHECK(*responses.edges(0, x + kMargin, 20 + kMargin) < DirectionResponses::kNothing + 30);
  }
}

TEST_CASE("places beside each other are places of one plane, kStep pixels apart") {
  const Square square;
  DirectionResponses responses;
  responses.compute(square.rgb.data(), Square::kWidth, square.says, Square::kWidth, Square::kHeight, 5);
  constexpr int kStep = DirectionResponses::kStep;
  for (int y = 3; y < 20; y += 3) {
    for (int x = 2; x < 20; x += 3) {
      const std::uint8_t* from = responses.edges(0, x, y);
      CHECK(from[3] == *responses.edges(0, x + 3 * kStep, y));
      CHECK(from[4 * responses.columns()] == *responses.edges(0, x, y + 4 * kStep));
    }
  }
}

TEST_CASE("turned, nearer and elsewhere in the picture: one of the poses proposed is near the truth in a few frames") {
  const Device device;
  Scene scene(device);
  const Pose T_last = pose_of({0.5, 0.4, 0.2}, {-0.05, -0.02, 0.42});
  const ColorHistograms colors = scene.colors_at(T_last);
  const std::vector<Pose> truths = {pose_of({0.5, 0.4, 0.2}, {0.06, 0.03, 0.42}),
                                    pose_of({0.9, 0.3, 0.5}, {0.05, 0.02, 0.46}),
                                    pose_of({0.2, 0.9, -0.2}, {-0.06, 0.03, 0.38})};
  for (const Pose& T_true : truths) {
    CAPTURE(T_true.translation().transpose());
    scene.show(T_true);
    CHECK(scene.nearest_within(6, T_last, T_true, colors, false) < 0.5);
    // Without the colours by the gradients alone.
    CHECK(scene.nearest_within(6, T_last, T_true, ColorHistograms(), false) < 0.6);
  }
}

TEST_CASE("a small budget proposes the same pose some frames later") {
  const Device device;
  Scene scene(device);
  const Pose T_last = pose_of({0.5, 0.4, 0.2}, {-0.05, -0.02, 0.42}),
             T_true = pose_of({0.9, 0.3, 0.5}, {0.05, 0.02, 0.46});
  const ColorHistograms colors = scene.colors_at(T_last);
  scene.show(T_true);
  const auto frames_until_near = [&](double budget_ms) {
    scene.search.end();
    for (int frame = 1; frame <= 40; ++frame) {
      if (scene.nearest(T_true, scene.search.starts(T_last, colors, budget_ms, false)) < 0.5) return frame;
    }
    return 1000;
  };
  const int most = frames_until_near(1000), usual = frames_until_near(kBudgetMs), least = frames_until_near(0);
  CHECK(most <= usual);
  CHECK(usual <= least);
  CHECK(least <= 40);
}

TEST_CASE("the same frames propose the same poses, and a new search begins anew") {
  const Device device;
  Scene scene(device);
  const Pose T_last = pose_of({0.5, 0.4, 0.2}, {-0.03, -0.02, 0.42});
  scene.show(pose_of({0.6, 0.5, 0.1}, {0.04, 0.02, 0.42}));
  const ColorHistograms colors;
  std::vector<std::vector<Pose>> first;
  for (int i = 0; i < 3; ++i) first.push_back(scene.search.starts(T_last, colors, kBudgetMs, false));
  scene.search.end();
  for (int i = 0; i < 3; ++i) {
    const std::vector<Pose> again = scene.search.starts(T_last, colors, kBudgetMs, false);
    REQUIRE(again.size() == first[static_cast<std::size_t>(i)].size());
    for (std::size_t n = 0; n < again.size(); ++n) {
      CHECK(again[n].matrix() == first[static_cast<std::size_t>(i)][n].matrix());
    }
  }
}

TEST_CASE("what shows quite another side is proposed once all sides have been looked at") {
  const Device device;
  Scene scene(device);
  const Pose T_last = pose_of({0.5, 0.4, 0.2}, {-0.05, -0.02, 0.42});
  const ColorHistograms colors = scene.colors_at(T_last);
  for (const Eigen::Vector3d& turn :
       {Eigen::Vector3d(2.2, 0.3, 0), Eigen::Vector3d(0.4, -1.5, 1), Eigen::Vector3d(0.3, 2.6, 0.4)}) {
    const Pose T_true = pose_of(turn, {0.04, 0.02, 0.4});
    CAPTURE(turn.transpose());
    REQUIRE(rotation_angle(T_true.linear().transpose() * T_last.linear()) > 1.5);
    scene.show(T_true);
    CHECK(scene.nearest_within(60, T_last, T_true, colors, true) < 0.6);
  }
}
