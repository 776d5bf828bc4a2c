// Frames of monochrome cameras, which videos and pictures keep as three equal channels.
#include <doctest/doctest.h>

#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

#include "holdfast/tracker.hpp"
#include "simulation/sequence.hpp"
#include "support/paper_box.hpp"
#include "support/simulated.hpp"
#include "video/tracker_view.hpp"

namespace {

using namespace holdfast;
using namespace holdfast::app;
using simulation::Sequence;

cv::Mat three_equal(const cv::Mat& grey) {
  cv::Mat bgr;
  cv::cvtColor(grey, bgr, cv::COLOR_GRAY2BGR);
  return bgr;
}

cv::Mat noise(cv::Size size) {
  cv::Mat grey(size, CV_8U);
  cv::theRNG().state = 11;
  cv::randu(grey, 0, 256);
  return grey;
}

}  // namespace

TEST_CASE("monochrome is what has three channels that agree, but for rounding, in every pixel") {
  const cv::Mat grey = three_equal(noise({37, 23}) * 0.9 + 10);
  CHECK(is_monochrome(grey));
  CHECK_FALSE(is_monochrome(cv::Mat()));
  for (const cv::Point place : {cv::Point(0, 0), cv::Point(36, 0), cv::Point(18, 11), cv::Point(36, 22)}) {
    for (const int channel : {0, 1, 2}) {
      for (const int by : {-3, -2, 2, 3}) {
        CAPTURE(place);
        CAPTURE(channel);
        CAPTURE(by);
        cv::Mat tinted = grey.clone();
        auto& value = tinted.at<cv::Vec3b>(place)[channel];
        value = static_cast<std::uint8_t>(value + by);
        CHECK(is_monochrome(tinted) == (std::abs(by) < 3));
      }
    }
  }
}

TEST_CASE("a tracker's view: one channel where there is one, else the frame's own memory") {
  const cv::Mat grey = noise({37, 23});
  cv::Mat held;
  const ImageView one = tracker_view(three_equal(grey), held);
  CHECK(one.format == PixelFormat::grey8);
  CHECK(one.data == held.data);
  CHECK(one.width == 37);
  CHECK(one.height == 23);
  CHECK(one.stride_bytes == held.step[0]);
  CHECK(cv::norm(held, grey, cv::NORM_INF) == 0);

  cv::Mat wide(40, 60, CV_8UC3, cv::Scalar(1, 100, 200));
  const cv::Mat part = wide(cv::Rect(5, 6, 37, 23));
  const ImageView color = tracker_view(part, held);
  CHECK(color.format == PixelFormat::bgr8);
  CHECK(color.data == part.data);
  CHECK(color.width == 37);
  CHECK(color.height == 23);
  CHECK(color.stride_bytes == wide.step[0]);
}

TEST_CASE("an object of many colours is held in monochrome frames, in every quality") {
  const Sequence sequence(test::box(), test::paper_camera(8, 2, 37));
  struct Case {
    std::string quality;
    TrackerOptions options;
    double millimetres, degrees;
  };
  // One solution a frame from where the last one led is as good as that.
  const std::vector<Case> cases{
      {"accurate", {}, 0.5, 0.2}, {"fast", TrackerOptions::fast(), 1, 0.2}, {"paper", TrackerOptions::paper(), 5, 1}};
  for (const Case& test : cases) {
    CAPTURE(test.quality);
    Tracker tracker(test::box(), sequence.camera(), test.options),
        as_color(test::box(), sequence.camera(), test.options);
    tracker.reset(sequence.pose(0));
    as_color.reset(sequence.pose(0));
    cv::Mat held;
    int used = 0, used_as_color = 0;
    for (int i = 0; i < sequence.size(); ++i) {
      CAPTURE(i);
      cv::Mat grey;
      cv::cvtColor(sequence.frame(i), grey, cv::COLOR_BGR2GRAY);
      const cv::Mat frame = three_equal(grey);
      const FrameResult result = tracker.track(tracker_view(frame, held));
      CHECK(result.status == Status::held);
      const test::PoseError error = test::pose_error(sequence.pose(i), result.T_camera_object);
      CHECK(error.millimetres < test.millimetres);
      CHECK(error.degrees < test.degrees);
      used += result.texture.used_pixels;
      used_as_color += as_color.track(test::view_of(frame)).texture.used_pixels;
    }
    // Taken for colours, many of its gradients are unlike the model's.
    CHECK(used > 1.2 * used_as_color);
  }
}
