#include "evaluation/frame_pictures.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "init/check_picture.hpp"

namespace holdfast::evaluation {

FramePictures::FramePictures(const Mesh& mesh, const Sequence& sequence, const Tracker& tracker,
                             std::filesystem::path folder, std::vector<int> frames)
    : sequence_(sequence),
      tracker_(tracker),
      overlay_(mesh, sequence.camera),
      folder_(std::move(folder)),
      frames_(std::move(frames)) {}

void FramePictures::draw(const FrameRecord& record) {
  if (std::find(frames_.begin(), frames_.end(), record.frame) == frames_.end()) {
    return;
  }
  app::TrackedFrame tracked;
  tracked.frame.image =
      cv::imread(sequence_.frames.at(static_cast<std::size_t>(record.frame)).string(), cv::IMREAD_COLOR);
  tracked.frame.index = record.frame;
  tracked.result = record.result;
  tracked.mask = tracker_.pixel_mask();
  const std::filesystem::path path =
      folder_ / fmt::format("{}_step{}_{:06d}.png", sequence_.name, record.step, record.frame);
  app::save_picture(path, overlay_.overlay_picture(tracked));
}

}  // namespace holdfast::evaluation
