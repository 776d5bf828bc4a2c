#include "evaluation/holdfast_run.hpp"

#include <fmt/core.h>

#include <chrono>
#include <opencv2/imgcodecs.hpp>

#include "evaluation/occluder_use.hpp"
#include "holdfast/error.hpp"
#include "video/tracker_view.hpp"

namespace holdfast::evaluation {

TrackerUnderTest under_test(Tracker& tracker, const Sequence& sequence) {
  TrackerUnderTest out;
  out.reset = [&tracker](const Pose& T_camera_object) { tracker.reset(T_camera_object); };
  const auto read = [&sequence](int frame) {
    const std::filesystem::path& path = sequence.frames.at(static_cast<std::size_t>(frame));
    const cv::Mat image = cv::imread(path.string(), cv::IMREAD_COLOR);
    if (image.empty()) {
      throw Error(ErrorCode::file, fmt::format("{}: not a readable image", path.string()));
    }
    if (image.cols != sequence.camera.width || image.rows != sequence.camera.height) {
      throw Error(ErrorCode::file,
                  fmt::format("{}: {}x{} pixels, but the sequence's first frame has {}x{}", path.string(), image.cols,
                              image.rows, sequence.camera.width, sequence.camera.height));
    }
    return image;
  };
  out.reset_on = [&tracker, read, grey = cv::Mat()](const Pose& T_camera_object, int frame) mutable {
    const cv::Mat image = read(frame);
    tracker.reset(T_camera_object, app::tracker_view(image, grey));
  };
  out.track = [&tracker, read, grey = cv::Mat()](int frame) mutable {
    const cv::Mat image = read(frame);
    const ImageView view = app::tracker_view(image, grey);
    const auto before = std::chrono::steady_clock::now();
    FrameResult result = tracker.track(view);
    result.ms.total = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - before).count();
    return result;
  };
  if (!sequence.occluder_masks.empty()) {
    out.inspect = [&tracker, &sequence](FrameRecord& record) {
      const std::filesystem::path& path = sequence.occluder_masks.at(static_cast<std::size_t>(record.frame));
      record.occluder = occluder_use(tracker.pixel_mask(), load_occluder_mask(path, sequence.camera));
    };
  }
  return out;
}

}  // namespace holdfast::evaluation
