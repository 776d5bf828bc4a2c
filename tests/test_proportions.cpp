// A model of wrong proportions is called so, along the right axis; one that is right is not, nor one of another size,
// which distance makes up for.
#include <doctest/doctest.h>

#include <string>
#include <utility>
#include <vector>

#include "holdfast/tracker.hpp"
#include "simulation/sequence.hpp"
#include "simulation/textured_box.hpp"
#include "support/simulated.hpp"

namespace {

using namespace holdfast;

const simulation::Sequence& sequence() {
  static const simulation::Sequence made(simulation::textured_box(), test::noisy_box(45, 121, 0.6, 0.8));
  return made;
}

/// What is said of the frames, one text a frame, tracking this model with this camera.
std::vector<std::string> reasons(const Eigen::Vector3f& stretch, double focal = 1) {
  static const std::vector<cv::Mat> frames = [] {
    std::vector<cv::Mat> out;
    for (int i = 0; i < sequence().size(); ++i) out.push_back(sequence().frame(i));
    return out;
  }();
  Mesh mesh = simulation::textured_box();
  for (Eigen::Vector3f& position : mesh.positions) position = position.cwiseProduct(stretch);
  Camera camera = sequence().camera();
  camera.fx *= focal;
  camera.fy *= focal;
  Tracker tracker(mesh, camera);
  tracker.reset(sequence().pose(0));
  std::vector<std::string> out;
  for (const cv::Mat& frame : frames) {
    const FrameResult result = tracker.track(test::view_of(frame));
    CHECK(result.status == Status::held);
    out.push_back(result.reason);
  }
  return out;
}

bool says_misfit(const std::string& reason) { return reason.starts_with("model"); }

}  // namespace

TEST_CASE("a right model, one that is larger, a wrong focal length: not a word of its proportions") {
  for (const auto& [size, focal] : {std::pair{1.0f, 1.0}, {1.03f, 1.0}, {0.97f, 1.0}, {1.0f, 1.03}, {1.0f, 0.97}}) {
    CAPTURE(size);
    CAPTURE(focal);
    for (const std::string& reason : reasons(Eigen::Vector3f::Constant(size), focal)) CHECK(!says_misfit(reason));
  }
}

TEST_CASE("one axis 3 % wrong: said so, which, and which way") {
  for (int axis = 0; axis < 3; ++axis) {
    for (const float stretch : {0.97f, 1.03f}) {
      CAPTURE(axis);
      CAPTURE(stretch);
      Eigen::Vector3f along = Eigen::Vector3f::Ones();
      along(axis) = stretch;
      const std::string last = reasons(along).back();
      CAPTURE(last);
      CHECK(says_misfit(last));
      // "too large along x beside y" is "too small along y beside x".
      CHECK(last.find(std::string(stretch > 1 ? "along " : "beside ") + "xyz"[axis]) != std::string::npos);
    }
  }
}
