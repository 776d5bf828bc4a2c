#include "arrays.hpp"

#include <algorithm>

namespace holdfast::python {
namespace {

std::string text_of(nb::handle value) { return nb::cast<std::string>(nb::str(value)); }

[[noreturn]] void refuse_value(const std::string& message) { throw nb::value_error(message.c_str()); }
[[noreturn]] void refuse_type(const std::string& message) { throw nb::type_error(message.c_str()); }

int channels_of(PixelFormat format) {
  switch (format) {
    case PixelFormat::bgr8:
    case PixelFormat::rgb8:
      return 3;
    case PixelFormat::rgba8:
    case PixelFormat::bgra8:
      return 4;
    case PixelFormat::yuyv:
      return 2;
    case PixelFormat::grey8:
    case PixelFormat::nv12:
      break;
  }
  return 1;
}

PixelFormat format_by_channels(int channels, const std::string& name, nb::handle value) {
  switch (channels) {
    case 1:
      return PixelFormat::grey8;
    case 3:
      return PixelFormat::bgr8;
    case 4:
      return PixelFormat::rgba8;
    default:
      refuse_value(name + ": expected shape HxWx3, HxWx4 or HxW, got " + described(value) +
                   (nb::cast<int>(value.attr("shape")[0]) <= 4
                        ? "; numpy.moveaxis(frame, 0, 2).copy() puts channels last"
                        : ""));
  }
}

std::string shape_of(const nb::ndarray<const double, nb::numpy, nb::c_contig, nb::ro>& array) {
  std::string shape;
  for (std::size_t i = 0; i < array.ndim(); ++i) shape += (i > 0 ? ", " : "") + std::to_string(array.shape(i));
  return "(" + shape + (array.ndim() == 1 ? ",)" : ")");
}

/// Bytes from a row to the next, where the array's pixels lie as a frame's do.
std::optional<std::size_t> row_stride(const nb::ndarray<nb::ro>& array, int channels) {
  const auto packed = static_cast<std::int64_t>(array.shape(1)) * channels;
  const bool channels_side_by_side = array.ndim() == 2 || array.shape(2) == 1 || array.stride(2) == 1;
  const bool pixels_side_by_side = array.shape(1) == 1 || array.stride(1) == channels;
  if (!channels_side_by_side || !pixels_side_by_side) return std::nullopt;
  if (array.shape(0) == 1) return static_cast<std::size_t>(packed);
  if (array.stride(0) < packed) return std::nullopt;
  return static_cast<std::size_t>(array.stride(0));
}

}  // namespace

std::string described(nb::handle value) {
  const std::string type = text_of(nb::handle(value.type()).attr("__name__"));
  if (!nb::hasattr(value, "shape") || !nb::hasattr(value, "dtype")) return type;
  return text_of(value.attr("dtype")) + " array of shape " + text_of(value.attr("shape"));
}

std::vector<double> numbers_argument(nb::handle value, const char* name, int rows, int columns) {
  using Numbers = nb::ndarray<const double, nb::numpy, nb::c_contig, nb::ro>;
  Numbers array;
  try {
    const nb::module_ numpy = nb::module_::import_("numpy");
    nb::object converted = numpy.attr("ascontiguousarray")(value, numpy.attr("float64"));
    array = nb::cast<Numbers>(converted);
  } catch (const nb::python_error&) {
    const bool text = nb::isinstance<nb::str>(value) || nb::hasattr(value, "__fspath__");
    refuse_type(std::string(name) + ": expected numbers, got " + described(value) +
                (text ? "; load_pose() and load_poses() read files" : ""));
  }
  const auto fits = [](std::size_t size, int wanted) { return wanted < 0 || size == static_cast<std::size_t>(wanted); };
  if (array.ndim() != 2 || !fits(array.shape(0), rows) || !fits(array.shape(1), columns)) {
    const auto count = [](int wanted) { return wanted < 0 ? std::string("N") : std::to_string(wanted); };
    refuse_value(std::string(name) + ": expected shape (" + count(rows) + ", " + count(columns) + "), got " +
                 (nb::hasattr(value, "shape") ? described(value) : described(value) + " of shape " + shape_of(array)));
  }
  return {array.data(), array.data() + array.size()};
}

Pose pose_argument(nb::handle value, const char* name) {
  const std::string shape = nb::hasattr(value, "shape") ? text_of(value.attr("shape")) : "";
  if (shape == "(3,)" || shape == "(3, 1)" || shape == "(1, 3)") {
    refuse_value(std::string(name) + ": expected shape (4, 4), got " + described(value) +
                 "; of OpenCV's rvec and tvec: T = numpy.eye(4); T[:3, :3] = cv2.Rodrigues(rvec)[0]; "
                 "T[:3, 3] = tvec.ravel()");
  }
  const bool upper = shape == "(3, 4)";
  const std::vector<double> numbers = numbers_argument(value, name, upper ? 3 : 4, 4);
  Pose pose = Pose::Identity();
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 4; ++column) {
      pose.matrix()(row, column) = numbers[static_cast<std::size_t>(4 * row + column)];
    }
  }
  if (!upper && !std::equal(numbers.begin() + 12, numbers.end(), std::begin({0.0, 0.0, 0.0, 1.0}))) {
    refuse_value(std::string(name) + ": the last row of a pose must be 0 0 0 1 (is the matrix transposed?)");
  }
  return pose;
}

FrameArgument frame_argument(nb::handle value, const char* name, std::optional<PixelFormat> format,
                             const char* repair) {
  FrameArgument frame;
  if (!nb::try_cast(value, frame.array, false)) {
    const bool file = nb::isinstance<nb::str>(value) || nb::hasattr(value, "__fspath__");
    const bool of_pillow = nb::hasattr(value, "convert") && nb::hasattr(value, "mode");
    const char* hint = value.is_none()               ? " (the end of the video?)"
                       : nb::hasattr(value, "image") ? ": pass its image"
                       : of_pillow                   ? ": pass numpy.asarray(picture.convert('RGB'))[..., ::-1].copy()"
                       : file                        ? ": Video() reads files, for frame in Video(...): frame.image"
                                                     : "";
    refuse_type(std::string(name) + ": expected a numpy array of uint8, got " + described(value) + hint);
  }
  const nb::ndarray<nb::ro>& array = frame.array;
  if (array.dtype() != nb::dtype<std::uint8_t>() || array.device_type() != nb::device::cpu::value) {
    refuse_type(std::string(name) + ": expected uint8 in main memory, got " + described(value) +
                "; floats from 0 to 1 are converted by (255 * x).astype(numpy.uint8), numbers up to 255 by "
                "x.astype(numpy.uint8), 16 bits by (x >> 8).astype(numpy.uint8)");
  }
  if (array.ndim() != 2 && array.ndim() != 3) {
    refuse_value(std::string(name) + ": expected shape HxWx3, HxWx4 or HxW, got " + described(value));
  }
  const int channels = array.ndim() == 2 ? 1 : static_cast<int>(array.shape(2));
  if (array.size() == 0) refuse_value(std::string(name) + ": has no pixels: " + described(value));
  const PixelFormat used = format ? *format : format_by_channels(channels, name, value);
  const bool planes = used == PixelFormat::nv12;
  if (channels != channels_of(used) || (planes && array.shape(0) % 3 != 0)) {
    refuse_value(std::string(name) + ": " + described(value) + " does not fit its format");
  }
  const std::optional<std::size_t> stride = row_stride(array, channels);
  if (!stride) {
    refuse_value(std::string(name) + ": pixels of a row must lie side by side and rows go downwards in memory: " +
                 described(value) + ", strides " + text_of(value.attr("strides")) + "; " + repair);
  }
  const auto rows = static_cast<int>(array.shape(0));
  frame.view = {static_cast<const std::uint8_t*>(array.data()), static_cast<int>(array.shape(1)),
                planes ? rows / 3 * 2 : rows, *stride, used};
  return frame;
}

cv::Mat bgr_matrix(const FrameArgument& frame, const char* name) {
  if (frame.view.format != PixelFormat::bgr8) {
    refuse_value(std::string(name) + ": expected a BGR frame, shape HxWx3");
  }
  // OpenCV has no matrix of constant memory; nothing writes to this one.
  return {frame.view.height, frame.view.width, CV_8UC3, const_cast<std::uint8_t*>(frame.view.data),
          frame.view.stride_bytes};
}

Numpy<double, nb::shape<-1, 4, 4>> poses_array(const std::vector<Pose>& poses) {
  std::vector<double> values;
  values.reserve(16 * poses.size());
  for (const Pose& pose : poses) {
    for (Eigen::Index i = 0; i < 16; ++i) values.push_back(pose.matrix()(i / 4, i % 4));
  }
  return owned_array<Numpy<double, nb::shape<-1, 4, 4>>>(std::move(values), {poses.size(), 4, 4});
}

Numpy<std::uint8_t> image_array(const cv::Mat& image) {
  cv::Mat packed = image.isContinuous() ? image : image.clone();
  auto owner = std::make_unique<cv::Mat>(std::move(packed));
  nb::capsule keep(owner.get(), [](void* held) noexcept { delete static_cast<cv::Mat*>(held); });
  const cv::Mat& held = *owner.release();
  const std::size_t shape[3] = {static_cast<std::size_t>(held.rows), static_cast<std::size_t>(held.cols),
                                static_cast<std::size_t>(held.channels())};
  return {held.data, held.channels() == 1 ? 2U : 3U, shape, keep};
}

}  // namespace holdfast::python
