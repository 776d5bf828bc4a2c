#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string_view>

#include "base/digest.hpp"
#include "detection/feature_data.hpp"
#include "holdfast/error.hpp"

// A line of text, "holdfast features 1 MODEL COUNT HASH", then COUNT points (three floats) and COUNT descriptors (128
// bytes), little-endian; HASH is of these.
namespace holdfast::detection {
namespace {

namespace fs = std::filesystem;

constexpr int kDescriptor = 128;
constexpr std::string_view kAnyKind = "holdfast features";
constexpr const char* kKind = "holdfast features 1";

std::string content_hash(const ModelFeatures::Data& data) {
  Digest hash;
  hash.add(data.p_object);
  hash.add(data.descriptors.data, data.descriptors.total());
  return hash.text();
}

[[noreturn]] void refuse(const fs::path& path, const std::string& why) {
  throw Error(ErrorCode::file, "the model's views in '" + path.string() + "' cannot be used: " + why +
                                   "; remove the file, it is made again");
}

}  // namespace

std::string model_hash(const Mesh& mesh) {
  Digest hash;
  hash.add(mesh.positions);
  hash.add(mesh.texture_coordinates);
  hash.add(mesh.colors);
  hash.add(mesh.triangles);
  hash.add(mesh.triangle_materials);
  for (const Material& material : mesh.materials) {
    hash.add(&material.texture.width, sizeof(int));
    hash.add(material.texture.rgba);
  }
  return hash.text();
}

void ModelFeatures::save(const fs::path& path) const {
  std::error_code failed;
  // Another process may read or write the same file: it only ever sees a complete one.
  const fs::path temporary = path.string() + ".tmp" + std::to_string(::getpid());
  {
    std::ofstream file(temporary, std::ios::binary);
    file << kKind << ' ' << data_->hash << ' ' << count() << ' ' << content_hash(*data_) << '\n';
    file.write(reinterpret_cast<const char*>(data_->p_object.data()),
               static_cast<std::streamsize>(count() * sizeof(Eigen::Vector3f)));
    file.write(reinterpret_cast<const char*>(data_->descriptors.data),
               static_cast<std::streamsize>(data_->descriptors.total()));
    file.flush();
    if (!file) failed = std::make_error_code(std::errc::io_error);
  }
  if (!failed) fs::rename(temporary, path, failed);
  if (failed) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw Error(ErrorCode::output, "the model's views cannot be written to '" + path.string() + "'");
  }
}

ModelFeatures ModelFeatures::load(const fs::path& path, const Mesh& mesh) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(ErrorCode::file, "the model's views '" + path.string() + "' cannot be read");
  std::string line;
  std::getline(file, line);
  if (!line.starts_with(kAnyKind)) {  // somebody else's: not to be removed
    throw Error(ErrorCode::file,
                "'" + path.string() + "' is no file of views or of remembered features: name another file");
  }
  if (!line.starts_with(kKind)) refuse(path, "it is no file of views of this version of Holdfast");
  std::istringstream words(line.substr(std::strlen(kKind)));
  const auto data = std::make_shared<Data>();
  std::size_t count = 0;
  std::string hash;
  words >> data->hash >> count >> hash;
  std::error_code failed;
  const std::uintmax_t size = fs::file_size(path, failed);
  if (!words || failed || count == 0 || count > size ||
      size != line.size() + 1 + count * (sizeof(Eigen::Vector3f) + kDescriptor)) {
    refuse(path, "it is damaged");
  }
  data->radius = mesh.radius();
  data->p_object.resize(count);
  data->descriptors.create(static_cast<int>(count), kDescriptor, CV_8U);
  file.read(reinterpret_cast<char*>(data->p_object.data()),
            static_cast<std::streamsize>(count * sizeof(Eigen::Vector3f)));
  file.read(reinterpret_cast<char*>(data->descriptors.data), static_cast<std::streamsize>(data->descriptors.total()));
  if (!file || content_hash(*data) != hash) refuse(path, "it is damaged");
  if (data->hash != model_hash(mesh)) refuse(path, "they are of another model, or of this one before it was changed");
  return ModelFeatures(data);
}

ModelFeatures ModelFeatures::kept_in(const fs::path& path, const Mesh& mesh) {
  std::error_code unknown;
  if (fs::exists(path, unknown)) return load(path, mesh);
  ModelFeatures made(mesh);
  made.save(path);
  return made;
}

}  // namespace holdfast::detection
