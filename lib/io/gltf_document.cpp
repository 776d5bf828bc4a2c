#include "io/gltf_document.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "io/json_text.hpp"
#include "io/model_fault.hpp"
#include "io/named_file.hpp"
#include "io/text_file.hpp"

namespace holdfast::io {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t kMostElements = std::size_t{1} << 26;  // of an accessor
constexpr std::size_t kMostZeros = std::size_t{1} << 22;     // elements that a short file may have without their data

const json kEmptyObject = json::object();
const json kEmptyList = json::array();

std::uint32_t little_endian(std::string_view bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

std::string decoded_base64(std::string_view text) {
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3);
  std::uint32_t block = 0;
  int bits = 0;
  for (const char c : text) {
    const int digit = c >= 'A' && c <= 'Z'   ? c - 'A'
                      : c >= 'a' && c <= 'z' ? c - 'a' + 26
                      : c >= '0' && c <= '9' ? c - '0' + 52
                      : c == '+' || c == '-' ? 62
                      : c == '/' || c == '_' ? 63
                                             : -1;
    if (digit < 0) continue;  // padding and line ends
    block = (block << 6 | static_cast<std::uint32_t>(digit)) & 0xffffff;
    bits += 6;
    if (bits >= 8) {
      bits -= 8;
      bytes += static_cast<char>(block >> bits & 0xff);
    }
  }
  return bytes;
}

std::size_t bytes_of_type(int type) {
  switch (type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      return 0;
  }
}

int type_of(std::optional<std::size_t> component_type) {
  return static_cast<int>(std::min<std::size_t>(component_type.value_or(0), 9999));
}

std::size_t components_of(const json& accessor) {
  const auto type = accessor.find("type");
  if (type == accessor.end() || !type->is_string()) return 0;
  constexpr std::pair<std::string_view, std::size_t> kinds[] = {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}};
  for (const auto& [name, count] : kinds) {
    if (type->get_ref<const std::string&>() == name) return count;
  }
  return 0;
}

template <class Stored>
float stored(const char* bytes, bool normalized) {
  Stored value;
  std::memcpy(&value, bytes, sizeof(value));
  if constexpr (!std::is_same_v<Stored, float>) {
    if (normalized) {
      return std::max(static_cast<float>(value) / static_cast<float>(std::numeric_limits<Stored>::max()), -1.0F);
    }
  }
  return static_cast<float>(value);
}

float component(int type, const char* bytes, bool normalized) {
  switch (type) {
    case 5120:
      return stored<std::int8_t>(bytes, normalized);
    case 5121:
      return stored<std::uint8_t>(bytes, normalized);
    case 5122:
      return stored<std::int16_t>(bytes, normalized);
    case 5123:
      return stored<std::uint16_t>(bytes, normalized);
    case 5125:
      return stored<std::uint32_t>(bytes, normalized);
    default:
      return stored<float>(bytes, normalized);
  }
}

}  // namespace

void GltfDocument::fail(const std::string& reason, const std::string& advice) const {
  fail_model(path_, reason, advice);
}

GltfDocument::GltfDocument(const fs::path& path) : path_(path) {
  read_container(read_text_file(path, "model"));
  if (!root_.is_object()) fail("it is no glTF document", kExportAnew);
  const json& version = part(part(root_, "asset"), "version");
  if (!version.is_string() || !version.get_ref<const std::string&>().starts_with("2")) {
    fail("it is not of glTF version 2", "export it as that");
  }
}

void GltfDocument::read_container(const std::string& bytes) {
  std::string_view text = bytes;
  if (text.starts_with("glTF")) {
    if (bytes.size() < 20) fail("it ends early");
    if (little_endian(text.substr(4)) != 2) fail("it is not of glTF version 2", "export it as that");
    const std::size_t length = little_endian(text.substr(12));
    if (text.substr(16, 4) != "JSON" || length > bytes.size() - 20) {
      fail(fmt::format("its first chunk of {} bytes is no document, or ends early", length));
    }
    std::string_view rest = text.substr(20 + length);
    text = text.substr(20, length);
    if (rest.size() >= 8 && rest.substr(4, 4) == std::string_view("BIN\0", 4)) {
      const std::size_t size = little_endian(rest);
      if (size > rest.size() - 8) fail(fmt::format("its binary chunk has {} of {} bytes", rest.size() - 8, size));
      chunk_ = rest.substr(8, size);
      has_chunk_ = true;
    }
  }
  try {
    root_ = parse_json_text(text);
  } catch (const std::runtime_error& error) {
    fail(error.what());
  }
}

const json& GltfDocument::part(const json& object, const char* key) const {
  if (!object.is_object()) return kEmptyObject;
  const auto found = object.find(key);
  return found == object.end() ? kEmptyObject : *found;
}

const json& GltfDocument::list(const json& object, const char* key) const {
  const json& found = part(object, key);
  return found.is_array() ? found : kEmptyList;
}

const json& GltfDocument::item(const char* list, std::size_t index) const {
  const json& items = this->list(root_, list);
  if (index >= items.size() || !items[index].is_object()) {
    fail(fmt::format("it refers to {} {}, which is not there", list, index));
  }
  return items[index];
}

std::optional<std::size_t> GltfDocument::index(const json& object, const char* key) const {
  if (!object.is_object() || !object.contains(key)) return std::nullopt;
  const json& value = object[key];
  if (!value.is_number() || !(value.get<double>() >= 0 && value.get<double>() < 1e15)) {
    fail(fmt::format("its '{}' is no number from 0 on", key), kExportAnew);
  }
  return static_cast<std::size_t>(value.get<double>());
}

double GltfDocument::number(const json& object, const char* key, double otherwise) const {
  if (!object.is_object() || !object.contains(key)) return otherwise;
  if (!object[key].is_number()) fail(fmt::format("its '{}' is no number", key), kExportAnew);
  return object[key].get<double>();
}

std::vector<double> GltfDocument::numbers(const json& object, const char* key, std::vector<double> otherwise) const {
  if (!object.is_object() || !object.contains(key)) return otherwise;
  const json& list = object[key];
  const bool good = list.is_array() && list.size() == otherwise.size() &&
                    std::all_of(list.begin(), list.end(), [](const json& value) { return value.is_number(); });
  if (!good) fail(fmt::format("its '{}' is no list of {} numbers", key, otherwise.size()), kExportAnew);
  return list.get<std::vector<double>>();
}

std::optional<std::string> GltfDocument::embedded(const std::string& uri) const {
  if (!uri.starts_with("data:")) return std::nullopt;
  const std::size_t comma = uri.find(',');
  if (comma == uri.npos || uri.substr(0, comma).find("base64") == uri.npos)
    fail("it has a data URI without base64", "export it as GLB");
  return decoded_base64(std::string_view(uri).substr(comma + 1));
}

const std::string& GltfDocument::buffer(std::size_t index) {
  if (const auto known = buffers_.find(index); known != buffers_.end()) return known->second;
  const json& described = item("buffers", index);
  const json& uri = part(described, "uri");
  std::string bytes;
  if (!uri.is_string()) {
    if (!has_chunk_ || index != 0) fail(fmt::format("its buffer {} has no data", index));
    bytes = chunk_;
  } else if (auto data = embedded(uri.get<std::string>())) {
    bytes = *std::move(data);
  } else {
    const auto file = named_file(uri.get<std::string>(), {path_.parent_path()});
    if (!file)
      fail(fmt::format("its buffer file '{}' does not exist", uri.get<std::string>()), "copy it beside the model");
    bytes = read_binary_file(*file, "buffer file");
  }
  const std::size_t length = this->index(described, "byteLength").value_or(0);
  if (length > bytes.size()) fail(fmt::format("its buffer {} has {} of {} bytes", index, bytes.size(), length));
  bytes.resize(length);
  return buffers_[index] = std::move(bytes);
}

std::string_view GltfDocument::view(std::size_t index) {
  const json& described = item("bufferViews", index);
  if (part(described, "extensions").contains("EXT_meshopt_compression")) {
    fail("it is compressed with EXT_meshopt_compression, which is not supported", "export it without");
  }
  const auto owner = this->index(described, "buffer");
  if (!owner) fail(fmt::format("its bufferView {} names no buffer", index), kExportAnew);
  const std::string& bytes = buffer(*owner);
  const std::size_t offset = this->index(described, "byteOffset").value_or(0);
  const std::size_t length = this->index(described, "byteLength").value_or(0);
  if (offset > bytes.size() || length > bytes.size() - offset) {
    fail(fmt::format("its bufferView {} reaches beyond its buffer", index));
  }
  return std::string_view(bytes).substr(offset, length);
}

std::string_view GltfDocument::elements(const json& owner, std::size_t offset, std::size_t size, std::size_t stride,
                                        std::size_t count) {
  const auto of = index(owner, "bufferView");
  if (!of) fail("an accessor has no data", kExportAnew);
  const std::string_view bytes = view(*of);
  const std::size_t needed = count == 0 ? 0 : (count - 1) * stride + size;
  if (offset > bytes.size() || needed > bytes.size() - offset) {
    fail(fmt::format("an accessor of {} elements reaches beyond its bufferView {}", count, *of));
  }
  return bytes.substr(offset, needed);
}

void GltfDocument::read_elements(const Layout& layout, std::string_view bytes, std::size_t stride, std::size_t count,
                                 float* values) const {
  const std::size_t size = bytes_of_type(layout.type);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < layout.components; ++k) {
      *values++ = component(layout.type, &bytes[i * stride + k * size], layout.normalized);
    }
  }
}

void GltfDocument::require_few(std::size_t accessor, std::size_t count) const {
  if (count <= kMostElements) return;
  fail(fmt::format("its accessor {} has {} elements, more than {}", accessor, count, kMostElements),
       "export it with fewer");
}

GltfValues GltfDocument::values(std::size_t accessor) {
  const json& described = item("accessors", accessor);
  const Layout layout{components_of(described), type_of(index(described, "componentType")),
                      part(described, "normalized") == json(true)};
  const std::size_t size = layout.components * bytes_of_type(layout.type);
  const std::size_t count = index(described, "count").value_or(0);
  if (size == 0) fail(fmt::format("its accessor {} is of no kind that is supported", accessor), kExportAnew);
  const bool sparse = part(described, "sparse").is_object() && described.contains("sparse");
  const auto of = index(described, "bufferView");
  if (!of && !sparse) fail(fmt::format("its accessor {} has no data", accessor), kExportAnew);
  GltfValues read{layout.components, {}};
  if (of) {
    std::size_t stride = index(item("bufferViews", *of), "byteStride").value_or(0);
    stride = stride == 0 ? size : stride;
    if (stride < size || stride > 4096)
      fail(fmt::format("its bufferView {} has a stride of {}", *of, stride), kExportAnew);
    const std::string_view bytes = elements(described, index(described, "byteOffset").value_or(0), size, stride, count);
    require_few(accessor, count);
    read.values.resize(count * layout.components);
    read_elements(layout, bytes, stride, count, read.values.data());
  } else {
    zeros_ += count;
    if (zeros_ > kMostZeros) fail(fmt::format("it has no data for {} elements of its accessors", zeros_), kExportAnew);
    read.values.resize(count * layout.components);
  }
  if (sparse) read_sparse(described, layout, read);
  return read;
}

void GltfDocument::read_sparse(const json& accessor, const Layout& layout, GltfValues& values) {
  const json& sparse = accessor["sparse"];
  const json& where = part(sparse, "indices");
  const json& what = part(sparse, "values");
  const std::size_t count = index(sparse, "count").value_or(0);
  const Layout whole{1, type_of(index(where, "componentType")), false};
  const std::size_t index_size = bytes_of_type(whole.type), size = layout.components * bytes_of_type(layout.type);
  if (index_size == 0 || count > values.count()) fail("a sparse accessor is of no kind that is supported", kExportAnew);
  const std::string_view places =
      elements(where, index(where, "byteOffset").value_or(0), index_size, index_size, count);
  const std::string_view bytes = elements(what, index(what, "byteOffset").value_or(0), size, size, count);
  for (std::size_t i = 0; i < count; ++i) {
    std::uint32_t place = 0;
    for (std::size_t k = index_size; k-- > 0;)
      place = place << 8 | static_cast<unsigned char>(places[i * index_size + k]);
    if (place >= values.count())
      fail(fmt::format("a sparse accessor names element {} of {}", place, values.count()), kExportAnew);
    read_elements(layout, bytes.substr(i * size, size), size, 1, &values.values[place * layout.components]);
  }
}

std::vector<std::uint32_t> GltfDocument::whole_values(std::size_t accessor) {
  const json& described = item("accessors", accessor);
  const int type = type_of(index(described, "componentType"));
  const std::size_t size = bytes_of_type(type), count = index(described, "count").value_or(0);
  if (components_of(described) != 1 || (type != 5121 && type != 5123 && type != 5125)) {
    fail(fmt::format("its accessor {} is no list of indices", accessor), kExportAnew);
  }
  const std::string_view bytes = elements(described, index(described, "byteOffset").value_or(0), size, size, count);
  require_few(accessor, count);
  std::vector<std::uint32_t> indices(count);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = size; k-- > 0;) {
      indices[i] = indices[i] << 8 | static_cast<unsigned char>(bytes[i * size + k]);
    }
  }
  return indices;
}

std::vector<fs::path> GltfDocument::named_files() const {
  std::vector<fs::path> files;
  for (const char* kind : {"buffers", "images"}) {
    for (const json& described : list(root_, kind)) {
      const json& uri = part(described, "uri");
      if (!uri.is_string() || uri.get_ref<const std::string&>().starts_with("data:")) continue;
      if (const auto file = named_file(uri.get<std::string>(), {path_.parent_path()})) files.push_back(*file);
    }
  }
  return files;
}

}  // namespace holdfast::io
