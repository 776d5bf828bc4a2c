// The search of a lost object over the whole picture: what it takes in a frame, and where it leads.
#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "device/device_impl.hpp"
#include "recovery/relocalizer.hpp"
#include "simulation/textured_box.hpp"
#include "support/render_comparison.hpp"

namespace {

using namespace holdfast;

const Camera kCamera{321, 243, 405, 398, 158.2, 119.9, {}};
constexpr int kLevels = 4;

/// A box in a picture, and what looks for it.
struct Search {
  explicit Search(const Pose& T_seen)
      : filter(device.impl()),
        view(device.impl(), mesh, view_renderer(mesh, levels, {}), levels, filter),
        image(device.impl(), kCamera, levels, filter),
        extent{mesh.center().cast<double>(), mesh.radius()},
        shifts(device.impl(), levels),
        relocalizer(levels, extent, shifts, view, image) {
    Renderer renderer(mesh, kCamera.width, kCamera.height);
    const test::View drawn = test::draw(renderer, T_seen, kCamera);
    const Rect whole{0, 0, kCamera.width, kCamera.height};
    image.enqueue_upload(ImageView{drawn.rgba.data(), kCamera.width, kCamera.height, 0, PixelFormat::rgba8},
                         image.region(whole));
    image.wait_for_upload();
    for (int level = 0; level < kLevels; ++level) image.enqueue_blur(level, coarser(whole, level));
  }

  bool draw(const Pose& T_camera_object, int level) {
    ++draws;
    ViewRequest request;
    request.T_camera_object = T_camera_object;
    request.finest = level;
    return view.enqueue(request);
  }

  /// Of one frame.
  std::vector<PoseCandidate> look(const Pose& T_last, double budget_ms) {
    draws = 0;
    const DrawView draw_view = [&](const Pose& T, int level) { return draw(T, level); };
    return relocalizer.search(draw_view, relocalizer.levels_for(T_last, 0, kLevels), budget_ms);
  }

  Device device;
  Mesh mesh = simulation::textured_box();
  std::vector<Level> levels = make_levels(kCamera, kLevels);
  ImageFilter filter;
  ViewTemplate view;
  DeviceImage image;
  Extent extent;
  ShiftSearch shifts;
  Relocalizer relocalizer;
  int draws = 0;
};

const Pose kSeen = test::pose_at({0.1, -0.05, 0.9}, {0.4, 0.5, 0.2});

/// The same appearance elsewhere.
Pose last_seen() { return test::pose_at({-0.12, 0.06, 0.9}, {0.4, 0.5, 0.2}); }

}  // namespace

TEST_CASE(
    "the more time a frame has, the more views it draws, up to a limit; with next to none it goes on all the same") {
  Search search(kSeen);
  const Pose T_last = last_seen();
  int before = 0;
  for (const double budget_ms : {0.0, 10.0, 25.0, 50.0, 100.0}) {
    CAPTURE(budget_ms);
    search.relocalizer.clear();
    search.relocalizer.begin(T_last);
    const std::vector<PoseCandidate> found = search.look(T_last, budget_ms);
    CHECK(search.draws > 5);
    CHECK(search.draws >= before);
    CHECK(search.draws < 60 + 8 * budget_ms);
    CHECK(found.size() <= Relocalizer::kMostCandidates);
    CHECK(std::is_sorted(found.begin(), found.end(),
                         [](const PoseCandidate& a, const PoseCandidate& b) { return a.score > b.score; }));
    before = search.draws;
  }
  CHECK(before < 400);
}

TEST_CASE("the same budget means the same views and the same candidates, however fast the machine is") {
  std::vector<std::vector<PoseCandidate>> found;
  int draws = 0;
  for (int run = 0; run < 2; ++run) {
    Search search(kSeen);
    search.relocalizer.begin(last_seen());
    found.push_back(search.look(last_seen(), 25));
    if (run > 0) CHECK(search.draws == draws);
    draws = search.draws;
  }
  REQUIRE(found[0].size() == found[1].size());
  for (std::size_t i = 0; i < found[0].size(); ++i) {
    CHECK(found[0][i].T_camera_object.matrix() == found[1][i].T_camera_object.matrix());
    CHECK(found[0][i].score == found[1][i].score);
  }
}

TEST_CASE("an object that was brought elsewhere is among the candidates, at last when all appearances were swept") {
  for (const double turn : {0.0, 0.3, 0.6}) {
    CAPTURE(turn);
    Search search(kSeen);
    Pose T_last = last_seen();
    T_last.linear() = Eigen::AngleAxisd(turn, Eigen::Vector3d(0.5, 1, -0.3).normalized()) * T_last.linear();
    search.relocalizer.begin(T_last);
    CHECK(search.relocalizer.searching());
    double nearest = 1e9;  // pixels
    for (int frame = 0; frame * 8 < search.relocalizer.planned() && nearest > 12; ++frame) {
      const std::vector<PoseCandidate> found = search.look(T_last, 25);
      for (const PoseCandidate& candidate : found) {
        nearest = std::min(nearest, corner_motion(search.extent, kCamera, kSeen, candidate.T_camera_object));
      }
      search.relocalizer.keep(found);
    }
    CHECK(nearest < 12);  // as far as an alignment from a coarse level reaches
  }
}
