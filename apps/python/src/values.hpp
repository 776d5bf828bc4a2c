#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <Eigen/Core>
#include <array>
#include <cstring>
#include <new>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <typeinfo>
#include <utility>
#include <vector>

#include "arrays.hpp"

/// Copies and pickles. A value is pickled as the tuple of its fields, so that results come back from other processes.
namespace holdfast::python {

/// Fixed numbers side by side, pickled as their bytes.
template <class T>
inline constexpr bool kFlat = std::is_arithmetic_v<T>;
template <class T, int Rows, int Columns>
inline constexpr bool kFlat<Eigen::Matrix<T, Rows, Columns>> = Rows > 0 && Columns > 0;
template <class T, std::size_t Size>
inline constexpr bool kFlat<std::array<T, Size>> = kFlat<T>;
template <>
inline constexpr bool kFlat<Pose> = true;

template <class T>
inline constexpr bool kVector = false;
template <class T>
inline constexpr bool kVector<std::vector<T>> = true;

template <class T>
inline constexpr bool kOptional = false;
template <class T>
inline constexpr bool kOptional<std::optional<T>> = true;

/// Structs that Python does not know: a function fields_of(const T*) beside the struct gives a tuple of its fields.
template <class T>
concept HasFieldTable = requires(const T* value) {
  fields_of(value);
};

/// Values whose fields must agree: a function is_sound(const T&) beside the struct says whether they do, or throws.
template <class T>
concept HasCheck = requires(const T& value) {
  is_sound(value);
};

[[noreturn]] inline void refuse_pickle() { throw nb::value_error("the pickle is of another version of holdfast"); }

template <class T>
nb::object state_of(const T& value) {
  if constexpr (std::is_same_v<T, cv::Mat>) {
    return nb::cast(image_array(value));
  } else if constexpr (HasFieldTable<T>) {
    return std::apply([&](auto... fields) -> nb::object { return nb::make_tuple(state_of(value.*fields)...); },
                      fields_of(&value));
  } else if constexpr (std::is_enum_v<T>) {
    return nb::int_(static_cast<int>(value));
  } else if constexpr (kOptional<T>) {
    return value ? state_of(*value) : nb::none();
  } else if constexpr (kVector<T>) {
    using Element = typename T::value_type;
    if constexpr (kFlat<Element>) return nb::bytes(value.data(), value.size() * sizeof(Element));
    nb::list states;
    for (const Element& element : value) states.append(state_of(element));
    return states;
  } else if constexpr (kFlat<T> && !std::is_arithmetic_v<T>) {
    return nb::bytes(value.data(), sizeof(T));
  } else {
    return nb::cast(value);
  }
}

template <class T>
void restore(nb::handle state, T& value);

/// Numbers of a state; `size`: the bytes that they must be, a multiple of it where `whole` is false.
inline nb::bytes bytes_of(nb::handle state, std::size_t size, bool whole) {
  auto bytes = nb::cast<nb::bytes>(state);
  if (bytes.size() % size != 0 || (whole && bytes.size() != size)) refuse_pickle();
  return bytes;
}

template <class T, class... Field>
void restore_fields(nb::handle state, T& value, Field T::*... fields) {
  const auto states = nb::cast<nb::tuple>(state);
  if (states.size() != sizeof...(fields)) refuse_pickle();
  std::size_t i = 0;
  (restore(states[i++], value.*fields), ...);
  if constexpr (HasCheck<T>) {
    if (!is_sound(value)) refuse_pickle();
  }
}

template <class T>
void restore(nb::handle state, T& value) {
  if constexpr (std::is_same_v<T, cv::Mat>) {
    const auto array = nb::cast<nb::ndarray<const std::uint8_t, nb::c_contig, nb::device::cpu>>(state);
    const std::size_t channels = array.ndim() == 3 ? array.shape(2) : array.ndim() == 2 ? 1 : 0;
    if (channels < 1 || channels > 4) refuse_pickle();
    value.create(static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)),
                 CV_8UC(static_cast<int>(channels)));
    std::memcpy(value.data, array.data(), array.size());
  } else if constexpr (HasFieldTable<T>) {
    std::apply([&](auto... fields) { restore_fields(state, value, fields...); }, fields_of(&value));
  } else if constexpr (std::is_enum_v<T>) {
    value = static_cast<T>(nb::cast<int>(state));
  } else if constexpr (kOptional<T>) {
    value.reset();
    if (!state.is_none()) restore(state, value.emplace());
  } else if constexpr (kVector<T>) {
    using Element = typename T::value_type;
    if constexpr (kFlat<Element>) {
      const nb::bytes bytes = bytes_of(state, sizeof(Element), false);
      value.resize(bytes.size() / sizeof(Element));
      if (!value.empty()) std::memcpy(static_cast<void*>(value.data()), bytes.data(), bytes.size());
    } else {
      for (nb::handle element : nb::cast<nb::list>(state)) restore(element, value.emplace_back());
    }
  } else if constexpr (kFlat<T> && !std::is_arithmetic_v<T>) {
    std::memcpy(value.data(), bytes_of(state, sizeof(T), true).data(), sizeof(T));
  } else {
    value = nb::cast<T>(state);
  }
}

/// Makes the class one whose objects copy.copy() and pickle take.
template <class T, class... Field>
void make_value(nb::class_<T>& bound, Field T::*... fields) {
  bound.def("__getstate__", [fields...](nb::handle self) {
    if (nb::len(nb::getattr(self, "__dict__", nb::tuple())) > 0) {
      throw nb::type_error("attributes of a subclass are not copied or pickled: give it a __reduce__");
    }
    const T& value = nb::cast<const T&>(self);
    return nb::make_tuple(state_of(value.*fields)...);
  });
  bound.def("__setstate__", [fields...](T& self, const nb::tuple& state) {
    T value{};
    try {
      restore_fields(state, value, fields...);
    } catch (const std::bad_cast&) {
      refuse_pickle();
    }
    new (&self) T(std::move(value));
  });
}

/// Makes the class say that its objects, which hold a device, a drawing context or an open file, are no values.
template <class T>
void make_unique_here(nb::class_<T>& bound) {
  bound.def("__reduce__", [](nb::handle self) -> nb::tuple {
    const std::string name = nb::cast<std::string>(nb::str(nb::handle(self.type()).attr("__name__")));
    throw nb::type_error(("a " + name + " cannot be copied or pickled: make one in each process; results, cameras " +
                          "and meshes can be sent to others")
                             .c_str());
  });
}

}  // namespace holdfast::python
