// A model without appearance compared with how a frame showed it.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "base/levels.hpp"
#include "device/device_impl.hpp"
#include "holdfast/tracker.hpp"
#include "image/view_template.hpp"
#include "recovery/snapshot_album.hpp"
#include "simulation/sequence.hpp"
#include "support/edge_shapes.hpp"
#include "support/paper_box.hpp"
#include "support/render_comparison.hpp"
#include "support/simulated.hpp"
#include "texture/print_agreement.hpp"

namespace {

using namespace holdfast;
using namespace holdfast::test;

/// A view of a painted square and a frame that shows it, on two levels.
struct Scene {
  explicit Scene(const Mesh& model)
      : mesh(model),
        levels(make_levels(kRenderCamera, 2)),
        filter(device.impl()),
        view(device.impl(), mesh, view_renderer(mesh, levels, {}), levels, filter),
        image(device.impl(), kRenderCamera, levels, filter) {}

  static ViewRequest request(const Pose& T_camera_object) {
    ViewRequest request;
    request.T_camera_object = T_camera_object;
    request.count = 2;
    return request;
  }

  /// The frame is what a renderer makes of this mesh, blurred and darkened.
  void upload(const Mesh& shown, const Pose& T_camera_object, double blur = 0, double gain = 1) {
    Renderer renderer(shown, kRenderCamera.width, kRenderCamera.height, {});
    const View drawn = draw(renderer, T_camera_object);
    cv::Mat(kRenderCamera.height, kRenderCamera.width, CV_8UC4, const_cast<std::uint8_t*>(drawn.rgba.data()))
        .convertTo(frame, CV_8U, gain);
    if (blur > 0) cv::GaussianBlur(frame, frame, {}, blur);
    image.enqueue_upload(view_of(frame, PixelFormat::rgba8), image.region({0, 0, frame.cols, frame.rows}));
    for (int level = 0; level < 2; ++level) image.enqueue_blur(level, image.uploaded(level));
  }

  std::vector<float> read(const cl::Buffer& buffer, std::size_t count) const {
    std::vector<float> values(count);
    device.impl().queue.enqueueReadBuffer(buffer, CL_TRUE, 0, count * sizeof(float), values.data());
    return values;
  }
  std::vector<float> planes(int level) const {
    const ViewTemplate::Planes& planes = view.planes(level);
    const std::size_t elements = levels[static_cast<std::size_t>(level)].elements;
    std::vector<float> all;
    for (const cl::Buffer* buffer : {&planes.value, &planes.dx, &planes.dy}) {
      const std::vector<float> values = read(*buffer, HF_CHANNELS * elements);
      all.insert(all.end(), values.begin(), values.end());
    }
    const std::vector<float> depth = read(planes.depth, elements);
    all.insert(all.end(), depth.begin(), depth.end());
    return all;
  }

  Device device;
  Mesh mesh;
  std::vector<Level> levels;
  ImageFilter filter;
  ViewTemplate view;
  DeviceImage image;
  cv::Mat frame;
};

double largest_difference(const std::vector<float>& a, const std::vector<float>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(static_cast<double>(a[i] - b[i])));
  return largest;
}

Snapshot turned(double angle, bool sure = true) {
  Snapshot snapshot;
  snapshot.T_camera_object.linear() = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY()).toRotationMatrix();
  snapshot.sure = sure;
  return snapshot;
}

/// Its shape alone.
Mesh bare(Mesh mesh) {
  mesh.materials.clear();
  mesh.triangle_materials.clear();
  mesh.texture_coordinates.clear();
  mesh.colors.clear();
  return mesh;
}

const Pose kAhead = pose_at({0.02, -0.01, 0.5}, {0.3, -0.2, 0.1});

}  // namespace

TEST_CASE("a snapshot of a frame that is the model's render is the rendered view") {
  Scene scene(quad(random_texture(32, 32, 1)));
  scene.upload(scene.mesh, kAhead);
  REQUIRE(scene.view.enqueue(Scene::request(kAhead)));
  const std::vector<float> rendered[] = {scene.planes(0), scene.planes(1)};
  scene.view.clear();
  REQUIRE(scene.view.enqueue(Scene::request(kAhead), &scene.image));
  for (int level = 0; level < 2; ++level) {
    CAPTURE(level);
    CHECK(largest_difference(scene.planes(level), rendered[level]) < 1.0 / 255);
  }
}

TEST_CASE("a snapshot that was read is shown again, bit by bit, whatever was shown in between") {
  Scene scene(quad(random_texture(32, 32, 1)));
  scene.upload(quad(random_texture(32, 32, 2)), kAhead);
  REQUIRE(scene.view.enqueue(Scene::request(kAhead), &scene.image));
  const Snapshot snapshot = scene.view.read_snapshot();
  CHECK(snapshot.T_camera_object.matrix() == kAhead.matrix());
  const ViewTemplate::Planes& planes = scene.view.planes(0);
  const Rect tiles{planes.tiles.x, planes.tiles.y, planes.tiles.width, planes.tiles.height};
  const std::vector<float> before[] = {scene.planes(0), scene.planes(1)};
  REQUIRE(scene.view.enqueue(Scene::request(pose_at({-0.05, 0.02, 0.6}))));
  scene.view.enqueue_snapshot(snapshot, 2);
  CHECK(scene.view.planes(0).tiles.x == tiles.x);
  CHECK(scene.view.planes(0).tiles.width == tiles.width);
  // Planes are written where the object is: elsewhere they may hold what was shown in between.
  const Snapshot again = scene.view.read_snapshot();
  CHECK(again.pixels == snapshot.pixels);
  CHECK(again.depth == snapshot.depth);
  scene.view.clear();
  scene.view.enqueue_snapshot(snapshot, 2);
  const std::vector<float> depth = scene.read(scene.view.planes(0).depth, scene.levels[0].elements);
  const std::vector<float> now = scene.planes(0);
  for (std::size_t i = 0; i < depth.size(); ++i) {
    if (depth[i] <= 0) continue;
    for (std::size_t plane = 0; plane < 3 * HF_CHANNELS; ++plane) {
      REQUIRE(now[plane * depth.size() + i] == before[0][plane * depth.size() + i]);
    }
  }
}

TEST_CASE("an album keeps a snapshot a side: the later, but none that something may hide for a sure one") {
  SnapshotAlbum album;
  CHECK(album.empty());
  album.add(turned(0));
  album.add(turned(0.1));
  CHECK(album.nearest(turned(0).T_camera_object, 1).T_camera_object.isApprox(turned(0.1).T_camera_object));
  album.add(turned(0.12, false));
  CHECK(album.nearest(turned(0).T_camera_object, 0).T_camera_object.isApprox(turned(0.1).T_camera_object));
  album.add(turned(0.8, false));
  album.add(turned(0.85, true));
  CHECK(album.nearest(turned(0).T_camera_object, 1).sure);
  CHECK(album.nearest(turned(0.9).T_camera_object, 0).T_camera_object.isApprox(turned(0.85).T_camera_object));
  // Full, it stays spread.
  for (int i = 0; i < 20; ++i) album.add(turned(-3 + 0.3 * i));
  for (std::size_t n = 0; n + 1 < SnapshotAlbum::kMost; ++n) {
    const Pose& T = album.nearest(turned(0).T_camera_object, n).T_camera_object;
    CHECK(rotation_angle(T.linear()) <=
          rotation_angle(album.nearest(turned(0).T_camera_object, n + 1).T_camera_object.linear()));
  }
}

TEST_CASE("the model's print is found in a frame that shows it, blurred and dark, and not in another's") {
  const Mesh model = quad(random_texture(24, 24, 1));
  Scene scene(model);
  const auto agreement = [&](const Mesh& shown, double blur, double gain) {
    scene.upload(shown, kAhead, blur, gain);
    REQUIRE(scene.view.enqueue(Scene::request(kAhead)));
    return print_agreement(scene.device.impl(), scene.view, scene.image, scene.levels[0]);
  };
  const PrintAgreement same = agreement(model, 0, 1);
  CHECK(same.pixels > 1000);
  CHECK(same.correlation > 0.97);
  CHECK_FALSE(agreement(model, 1.5, 0.4).missing());
  for (unsigned seed = 2; seed < 8; ++seed) {
    CAPTURE(seed);
    const PrintAgreement other = agreement(quad(random_texture(24, 24, seed)), 0, 1);
    CHECK(other.pixels == same.pixels);
    CHECK(other.missing());
  }
  // One colour is no print.
  Scene plain(quad(plain_texture(16, {120, 90, 60, 255})));
  plain.upload(model, kAhead);
  REQUIRE(plain.view.enqueue(Scene::request(kAhead)));
  CHECK_FALSE(print_agreement(plain.device.impl(), plain.view, plain.image, plain.levels[0]).missing());
}

TEST_CASE(
    "a printed box behind bars is followed by its bare shape in grey frames, better with snapshots than without") {
  const Mesh shape = bare(box());
  double error = 0, error_without = 0;
  long held = 0, held_without = 0, asked = 0;
  for (const std::uint64_t seed : {5, 6, 7}) {
    CAPTURE(seed);
    simulation::SequenceOptions motion = noisy_box(60, seed, 0.5, 0.7);
    motion.occluders = {simulation::OccluderOptions{}};
    const simulation::Sequence sequence(box(), motion);
    for (const bool with : {true, false}) {
      TrackerOptions options;
      if (!with) options.ablate = {"snapshot"};
      Tracker tracker(shape, sequence.camera(), options);
      for (int i = 0; i < sequence.size(); ++i) {
        cv::Mat grey;
        cv::cvtColor(sequence.frame(i), grey, cv::COLOR_BGR2GRAY);
        if (i == 0) tracker.reset(sequence.pose(0), view_of(grey, PixelFormat::grey8));
        const FrameResult result = tracker.track(view_of(grey, PixelFormat::grey8));
        (with ? held : held_without) += result.status == Status::held ? 1 : 0;
        const PoseError off = pose_error(sequence.pose(i), result.T_camera_object);
        (with ? error : error_without) += std::min(off.degrees, 20.0);
        if (!with) CHECK_FALSE(result.snapshot.asked);
        if (with) asked += result.snapshot.asked ? 1 : 0;
      }
    }
  }
  MESSAGE("asked " << asked << ", held " << held << " and " << held_without << " of 180, degrees off " << error / 180
                   << " and " << error_without / 180);
  CHECK(asked > 120);
  CHECK(held >= 170);
  CHECK(held >= held_without);
  CHECK(error < error_without);
}

TEST_CASE("frames are compared with a snapshot of print, not with one of a bare object") {
  for (const bool printed : {true, false}) {
    CAPTURE(printed);
    const simulation::Sequence sequence(printed ? box() : can(0.05F, 0.15F, 48), noisy_box(12, 9, 0.5, 0.7));
    Tracker tracker(printed ? bare(box()) : can(0.05F, 0.15F, 48), sequence.camera());
    tracker.reset(sequence.pose(0));
    for (int i = 0; i < sequence.size(); ++i) {
      CAPTURE(i);
      const FrameResult result = tracker.track(view_of(sequence.frame(i)));
      CHECK(result.status == Status::held);
      if (i > 2) CHECK(result.snapshot.asked == printed);
    }
  }
}

TEST_CASE("a box with another print in the model's place is not held") {
  const simulation::Sequence sequence(box(), noisy_box(12, 9, 0.5, 0.7));
  simulation::BoxOptions another;
  another.seed = 2;
  const Mesh other = simulation::textured_box(another);
  Tracker right(box(), sequence.camera()), wrong(other, sequence.camera());
  right.reset(sequence.pose(0));
  wrong.reset(sequence.pose(0));
  for (int i = 0; i < sequence.size(); ++i) {
    CAPTURE(i);
    const cv::Mat frame = sequence.frame(i);
    CHECK(right.track(view_of(frame)).status == Status::held);
    const FrameResult result = wrong.track(view_of(frame));
    CHECK(result.status == Status::lost);
    CHECK(result.reason != Reason::none);
  }
}
