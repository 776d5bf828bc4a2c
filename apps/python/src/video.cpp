#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>

#include "arrays.hpp"
#include "bindings.hpp"
#include "holdfast/error.hpp"
#include "values.hpp"
#include "video/frame_source.hpp"

namespace holdfast::python {
namespace {

using app::Frame;
using app::FrameSource;
using app::FrameSourceOptions;

void open(FrameSource* self, nb::object input, std::int64_t start, std::optional<std::int64_t> stop,
          std::int64_t stride, double frame_rate) {
  const std::string name = nb::cast<std::string>(nb::str(input));
  FrameSourceOptions options;
  options.start = start;
  options.stop = stop;
  options.stride = stride;
  options.frame_rate = frame_rate;
  constexpr int keep = 0;
  setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", keep);  // what is wrong is in the exception, and not on stderr as well
  const nb::gil_scoped_release released;
  new (self) FrameSource(name, options);
}

Frame next_frame(FrameSource& source) {
  Frame frame;
  bool there = false;
  {
    const nb::gil_scoped_release released;
    there = source.next(frame);
  }
  if (!there) {
    const std::optional<std::string> early = source.ended_early();
    if (early && PyErr_WarnEx(PyExc_UserWarning, early->c_str(), 1) != 0) throw nb::python_error();
    throw nb::stop_iteration();
  }
  return frame;
}

Numpy<std::uint8_t> decode_image(const nb::bytes& data) {
  cv::Mat image;
  {
    const cv::_InputArray encoded(static_cast<const std::uint8_t*>(data.data()), static_cast<int>(data.size()));
    const nb::gil_scoped_release released;
    if (data.size() > 0) image = cv::imdecode(encoded, cv::IMREAD_ANYCOLOR);
  }
  if (image.empty()) throw Error(ErrorCode::image, "the bytes are no picture that can be decoded (JPEG, PNG, ...)");
  return image_array(image);
}

}  // namespace

void bind_video(nb::module_& module) {
  nb::class_<Frame> frame_class(module, "Frame", "A frame of a video.");
  make_value(frame_class, &Frame::image, &Frame::index, &Frame::time_s);
  frame_class
      .def_prop_ro(
          "image", [](const Frame& frame) { return image_array(frame.image); }, "HxWx3 uint8, BGR, as recorded.",
          kNewArray)
      .def_ro("index", &Frame::index, "Number of the frame in the input.")
      .def_ro("time", &Frame::time_s, "Seconds from the input's first frame.")
      .def("__repr__", [](const Frame& frame) {
        return fmt::format("<Frame {} at {:.3f} s, {}x{} pixels>", frame.index, frame.time_s, frame.image.cols,
                           frame.image.rows);
      });
  nb::class_<FrameSource> video_class(
      module, "Video", nb::type_slots(kCheckedCalls),
      "Iterates over the frames of a video file, an image folder, an image pattern "
      "('frames/%06d.png', 'frames/*.png') or a camera's number, once: a second loop needs another Video. Warns where "
      "the input ends early.");
  make_unique_here(video_class);
  video_class
      .def(
          "__init__", &open, nb::arg("input"), nb::arg("start") = 0, nb::arg("stop") = nb::none(),
          nb::arg("stride") = 1, nb::arg("frame_rate") = 0.0,
          nb::sig("def __init__(self, input: str | os.PathLike | int, start: int = 0, stop: int | None = None, stride: "
                  "int = 1, frame_rate: float = 0) -> None"),
          "start, stop, stride: as in range(). frame_rate: frames a second of images, or instead of a video's own; 0: "
          "30, or the video's.")
      .def(
          "__iter__", [](nb::object self) { return self; }, nb::sig("def __iter__(self) -> Video"))
      .def("__next__", &next_frame)
      .def("__repr__",
           [](const FrameSource& source) {
             const auto count = source.frame_count();
             return fmt::format("<Video of {}x{} pixels, {} frames>", source.size().width, source.size().height,
                                count ? std::to_string(*count) : "unknown");
           })
      .def_prop_ro(
          "width", [](const FrameSource& source) { return source.size().width; }, "Pixels.")
      .def_prop_ro(
          "height", [](const FrameSource& source) { return source.size().height; }, "Pixels.")
      .def_prop_ro("frame_rate", &FrameSource::frame_rate, "Frames a second, without stride.")
      .def_prop_ro("frame_count", &FrameSource::frame_count, "Frames in all; None where the input does not tell.")
      .def_prop_ro("ended_early", &FrameSource::ended_early,
                   "At the end: why the input ended early; None where it did not.");
  module.def("decode_image", &decode_image, nb::arg("data"),
             "A picture of the bytes of a JPEG, PNG, ...: HxWx3 uint8, BGR, or HxW where it is grey.");
}

}  // namespace holdfast::python
