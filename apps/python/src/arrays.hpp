#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "holdfast/image_view.hpp"
#include "holdfast/pose.hpp"

/// Between numpy arrays and the library's types. Arguments are checked here: a TypeError says that an argument is no
/// array of the right kind, a ValueError that its shape or layout is wrong; both name the argument and its shape.
namespace holdfast::python {

namespace nb = nanobind;

/// Properties make a new array at each access.
inline constexpr auto kNewArray = nb::rv_policy::automatic;

/// "float64 array of shape (3, 2)" or the name of the type.
std::string described(nb::handle value);

/// A 4x4 matrix (or its upper 3x4), object to camera.
Pose pose_argument(nb::handle value, const char* name);

/// Numbers of any shape as float64, row by row; `columns`: the number that each row must have, `rows` likewise (-1:
/// any).
std::vector<double> numbers_argument(nb::handle value, const char* name, int rows, int columns);

/// A frame that lies in a caller's array. The array lives as long as this does.
struct FrameArgument {
  nb::ndarray<nb::ro> array;
  ImageView view;
};

/// HxWx3, HxWx4 or HxW of uint8; rows may be apart, pixels of a row may not. Without `format`: bgr8, rgba8 or grey8 by
/// the number of channels. `repair`: what makes pixels lie as they must, for the message.
FrameArgument frame_argument(nb::handle value, const char* name, std::optional<PixelFormat> format,
                             const char* repair =
                                 "pass numpy.ascontiguousarray of it (track() takes RGB without turning it round: "
                                 "format=PixelFormat.rgb8)");

/// A BGR frame as OpenCV's matrix, without a copy.
cv::Mat bgr_matrix(const FrameArgument& frame, const char* name);

template <class T, class... Traits>
using Numpy = nb::ndarray<nb::numpy, T, Traits...>;

using Numpy4x4 = Numpy<double, nb::shape<4, 4>>;
using Numpy6x6 = Numpy<double, nb::shape<6, 6>>;

/// The values as an array that owns them.
template <class Result, class Values>
Result owned_array(Values values, std::initializer_list<std::size_t> shape) {
  auto owner = std::make_unique<Values>(std::move(values));
  auto* data = owner->data();
  nb::capsule keep(owner.get(), [](void* held) noexcept { delete static_cast<Values*>(held); });
  owner.release();  // NOLINT: the capsule deletes it
  return Result(data, shape.size(), shape.begin(), keep);
}

/// A copy, row by row.
template <class Result, class Matrix>
Result matrix_array(const Matrix& matrix) {
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(matrix.size()));
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) values.push_back(matrix(row, column));
  }
  return owned_array<Result>(std::move(values),
                             {static_cast<std::size_t>(matrix.rows()), static_cast<std::size_t>(matrix.cols())});
}

inline Numpy4x4 pose_array(const Pose& pose) { return matrix_array<Numpy4x4>(pose.matrix()); }

/// Poses as an array of shape Nx4x4.
Numpy<double, nb::shape<-1, 4, 4>> poses_array(const std::vector<Pose>& poses);

/// The matrix's own memory as an array: HxWx3 or HxW of uint8. Empty: 0x0.
Numpy<std::uint8_t> image_array(const cv::Mat& image);

}  // namespace holdfast::python
