#include "support/small_sequence.hpp"

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "holdfast/io.hpp"
#include "simulation/sequence.hpp"
#include "simulation/textured_box.hpp"

namespace holdfast::test {

std::vector<Pose> write_small_sequence(const TemporaryFolder& folder, int frames, double speed) {
  const Mesh box = simulation::textured_box();
  simulation::SequenceOptions options;
  options.camera = kSmallCamera;
  options.frames = frames;
  options.samples = 2;
  options.motion.speed = speed;
  const simulation::Sequence sequence(box, options);
  std::filesystem::create_directory(folder / "frames");
  for (int i = 0; i < frames; ++i) {
    cv::imwrite((folder / ("frames/" + std::to_string(i) + ".png")).string(), sequence.frame(i));
  }
  io::save_model(folder / "box.obj", box);
  io::save_camera(folder / "camera.yml", options.camera);
  io::save_pose(folder / "first.txt", sequence.pose(0));
  return sequence.poses();
}

}  // namespace holdfast::test
