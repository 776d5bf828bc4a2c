#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

#include "io/ply_header.hpp"

namespace holdfast::io {

/// The values after a PLY file's header, one after the other. All functions throw Error(file) where the file ends.
class PlyValues {
 public:
  /// `data` and `path` must stay; `path` is for messages.
  PlyValues(std::string_view data, PlyHeader::Encoding encoding, const std::filesystem::path& path)
      : data_(data), encoding_(encoding), path_(&path) {}

  /// The values of one property: one, or as many as its list has.
  void next(const PlyHeader::Property& property, std::vector<double>& values);

 private:
  double next(PlyHeader::Type type);
  double next_word();
  template <class Stored>
  double next_stored();

  std::string_view data_;
  PlyHeader::Encoding encoding_;
  const std::filesystem::path* path_;
};

}  // namespace holdfast::io
