#include "io/calibration_fields.hpp"

#include <fmt/format.h>

#include <cctype>

#include "holdfast/error.hpp"

namespace holdfast::io {

using nlohmann::json;
namespace fs = std::filesystem;

void fail_camera(const fs::path& path, const std::string& reason) {
  throw Error(ErrorCode::camera, fmt::format("camera file '{}': {}", path.string(), reason));
}

namespace {

void flatten(const json& node, std::vector<double>& values, const fs::path& path, const std::string& name) {
  if (node.is_number()) {
    values.push_back(node.get<double>());
  } else if (node.is_array()) {
    for (const json& child : node) {
      flatten(child, values, path, name);
    }
  } else {
    fail_camera(path, fmt::format("'{}' holds something that is not a number", name));
  }
}

}  // namespace

std::string plain_key(const std::string& name) {
  std::string plain;
  for (const unsigned char c : name) {
    if (std::isalnum(c)) {
      plain += static_cast<char>(std::tolower(c));
    }
  }
  return plain;
}

const json* find_field(const json& document, std::initializer_list<std::string_view> names) {
  for (const std::string_view name : names) {
    for (const auto& [key, value] : document.items()) {
      if (plain_key(key) == name) {
        return &value;
      }
    }
  }
  return nullptr;
}

std::vector<double> matrix_values(const json& node, const fs::path& path, const std::string& name) {
  std::vector<double> values;
  const json* data = node.is_object() ? find_field(node, {"data"}) : &node;
  if (data == nullptr) {
    fail_camera(path, fmt::format("'{}' has no 'data'", name));
  }
  flatten(*data, values, path, name);
  return values;
}

double number_of(const json& node, const fs::path& path, const std::string& name) {
  if (!node.is_number()) {
    fail_camera(path, fmt::format("'{}' is not a number", name));
  }
  return node.get<double>();
}

}  // namespace holdfast::io
