#include "io/ply_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <optional>

#include "io/model_fault.hpp"
#include "io/numbers.hpp"

namespace holdfast::io {

using Type = PlyHeader::Type;

void PlyValues::next(const PlyHeader::Property& property, std::vector<double>& values) {
  const double count = property.count_type ? next(*property.count_type) : 1;
  if (!(count >= 0 && count <= static_cast<double>(data_.size()))) {
    fail_model(*path_, fmt::format("a list '{}' of {} values", property.name, count));
  }
  values.clear();
  for (double i = 0; i < count; ++i) {
    values.push_back(next(property.type));
  }
}

double PlyValues::next_word() {
  data_.remove_prefix(std::min(data_.find_first_not_of(" \t\r\n"), data_.size()));
  if (data_.empty()) {
    fail_model(*path_, "it ends early");
  }
  const std::string_view word = data_.substr(0, data_.find_first_of(" \t\r\n"));
  data_.remove_prefix(word.size());
  const std::optional<double> value = parse_number(word);
  if (!value) {
    fail_model(*path_, fmt::format("'{}' is not a number", word.substr(0, 20)), advice_on_number(word));
  }
  return *value;
}

template <class Stored>
double PlyValues::next_stored() {
  char bytes[sizeof(Stored)];
  if (data_.size() < sizeof(Stored)) {
    fail_model(*path_, "it ends early");
  }
  std::memcpy(bytes, data_.data(), sizeof(Stored));
  data_.remove_prefix(sizeof(Stored));
  const bool swapped = (encoding_ == PlyHeader::Encoding::big_endian) != (std::endian::native == std::endian::big);
  if (swapped) {
    std::reverse(std::begin(bytes), std::end(bytes));
  }
  Stored value;
  std::memcpy(&value, bytes, sizeof(Stored));
  return static_cast<double>(value);
}

double PlyValues::next(Type type) {
  if (encoding_ == PlyHeader::Encoding::text) return next_word();
  switch (type) {
    case Type::int8:
      return next_stored<std::int8_t>();
    case Type::uint8:
      return next_stored<std::uint8_t>();
    case Type::int16:
      return next_stored<std::int16_t>();
    case Type::uint16:
      return next_stored<std::uint16_t>();
    case Type::int32:
      return next_stored<std::int32_t>();
    case Type::uint32:
      return next_stored<std::uint32_t>();
    case Type::float32:
      return next_stored<float>();
    case Type::float64:
      return next_stored<double>();
  }
  fail_model(*path_, "unknown type");
}

}  // namespace holdfast::io
