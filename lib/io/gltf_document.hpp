#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace holdfast::io {

/// Values of a glTF accessor, one element after the other; normalized integers as what they stand for.
struct GltfValues {
  std::size_t components = 0;
  std::vector<float> values;
  std::size_t count() const { return components == 0 ? 0 : values.size() / components; }
};

/// A glTF 2.0 file (.gltf or .glb) with its buffers. Every index, offset and count is checked against what there is:
/// all functions throw Error(file) that says what is wrong.
class GltfDocument {
 public:
  explicit GltfDocument(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return path_; }
  const nlohmann::json& root() const { return root_; }

  /// Element `index` of the top-level list `list`.
  const nlohmann::json& item(const char* list, std::size_t index) const;
  /// The whole number, not negative, that an object has there; nothing where it has none.
  std::optional<std::size_t> index(const nlohmann::json& object, const char* key) const;
  /// The number that an object has there, or `otherwise`.
  double number(const nlohmann::json& object, const char* key, double otherwise) const;
  /// The list of `count` numbers that an object has there, or `otherwise`.
  std::vector<double> numbers(const nlohmann::json& object, const char* key, std::vector<double> otherwise) const;
  /// The object or list that stands there, or an empty one.
  const nlohmann::json& part(const nlohmann::json& object, const char* key) const;
  /// The list that stands there, or an empty one.
  const nlohmann::json& list(const nlohmann::json& object, const char* key) const;

  GltfValues values(std::size_t accessor);
  /// The values of an accessor of whole numbers, such as a primitive's indices.
  std::vector<std::uint32_t> whole_values(std::size_t accessor);
  /// The bytes of a buffer view.
  std::string_view view(std::size_t index);
  /// The bytes behind a data URI; nothing for another URI.
  std::optional<std::string> embedded(const std::string& uri) const;
  /// The files that buffers and images name, as far as they are there.
  std::vector<std::filesystem::path> named_files() const;

  [[noreturn]] void fail(const std::string& reason, const std::string& advice = "is the file complete?") const;

 private:
  struct Layout {
    std::size_t components = 0;
    int type = 0;  ///< componentType
    bool normalized = false;
  };

  void read_container(const std::string& bytes);
  const std::string& buffer(std::size_t index);
  void read_elements(const Layout& layout, std::string_view bytes, std::size_t stride, std::size_t count,
                     float* values) const;
  void require_few(std::size_t accessor, std::size_t count) const;
  void read_sparse(const nlohmann::json& accessor, const Layout& layout, GltfValues& values);
  /// The bytes of `count` elements of a view, from `offset` on, `stride` apart.
  std::string_view elements(const nlohmann::json& owner, std::size_t offset, std::size_t size, std::size_t stride,
                            std::size_t count);

  std::filesystem::path path_;
  std::string chunk_;  ///< the binary chunk of a GLB file
  bool has_chunk_ = false;
  nlohmann::json root_;
  std::map<std::size_t, std::string> buffers_;
  std::size_t zeros_ = 0;  ///< elements read that no buffer view holds, of all accessors together
};

}  // namespace holdfast::io
