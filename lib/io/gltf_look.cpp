#include "io/gltf_look.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "holdfast/error.hpp"
#include "holdfast/io.hpp"
#include "io/model_fault.hpp"
#include "io/named_file.hpp"
#include "io/texture_file.hpp"

namespace holdfast::io {
namespace {

using nlohmann::json;
using Color = std::array<std::uint8_t, 4>;

/// sRGB's curve: a linear share of light as it is encoded, and back.
double encoded(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

double decoded(double value) { return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4); }

std::uint8_t to_byte(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(std::isnan(value) ? 0 : value, 0.0, 1.0) * 255));
}

Wrap wrap_of(std::optional<std::size_t> mode) {
  constexpr std::size_t clamp = 33071, mirror = 33648;
  return mode == clamp ? Wrap::clamp : mode == mirror ? Wrap::mirror : Wrap::repeat;
}

void read_transform(const GltfDocument& document, const json& use, GltfLook& look) {
  const json& transform = document.part(document.part(use, "extensions"), "KHR_texture_transform");
  const std::vector<double> offset = document.numbers(transform, "offset", {0, 0});
  const std::vector<double> scale = document.numbers(transform, "scale", {1, 1});
  const double rotation = document.number(transform, "rotation", 0);
  const double c = std::cos(rotation), s = std::sin(rotation);
  look.turn << c * scale[0], s * scale[1], -s * scale[0], c * scale[1];  // v goes down here
  look.offset << offset[0], offset[1];
  look.coordinate_set = document.index(transform, "texCoord").value_or(look.coordinate_set);
}

/// The image of a texture: its plain one, or WebP's.
std::optional<std::size_t> image_of(const GltfDocument& document, const json& texture) {
  const json& extensions = document.part(texture, "extensions");
  if (const auto plain = document.index(texture, "source")) return plain;
  if (const auto webp = document.index(document.part(extensions, "EXT_texture_webp"), "source")) return webp;
  for (const auto& [name, ignored] : extensions.items()) {
    throw Error(ErrorCode::model, fmt::format("model '{}' has a texture of the kind '{}', which is not supported: "
                                              "export it with PNG or JPEG",
                                              document.path().string(), name));
  }
  return std::nullopt;
}

/// The first image of the same data: exporters may list a picture once a material.
std::size_t first_alike(const GltfDocument& document, std::size_t index) {
  const json& wanted = document.item("images", index);
  const auto same = [&](std::size_t i, const char* key) {
    return document.part(document.item("images", i), key) == document.part(wanted, key);
  };
  std::size_t i = 0;
  while (i < index && !(same(i, "uri") && same(i, "bufferView"))) ++i;
  return i;
}

void read_texture(const GltfDocument& document, const json& use, GltfLook& look) {
  const auto index = document.index(use, "index");
  if (!index) return;
  const json& texture = document.item("textures", *index);
  look.image = image_of(document, texture);
  look.lacks_image = !look.image.has_value();
  if (look.image) look.image = first_alike(document, *look.image);
  look.coordinate_set = document.index(use, "texCoord").value_or(0);
  read_transform(document, use, look);
  if (const auto sampler = document.index(texture, "sampler")) {
    const json& described = document.item("samplers", *sampler);
    look.wrapping = {wrap_of(document.index(described, "wrapS")), wrap_of(document.index(described, "wrapT"))};
  }
}

}  // namespace

std::string GltfLook::picture() const {
  return fmt::format("{} {} {} {}", image.value_or(0), fmt::join(factor, " "), opaque, cutoff.value_or(-1));
}

Eigen::Vector2f GltfLook::place(float u, float v) const {
  const Eigen::Vector2d moved = turn * Eigen::Vector2d(u, v) + offset;
  return {static_cast<float>(moved.x()), static_cast<float>(1 - moved.y())};
}

Color GltfLook::color_of(const float* values, std::size_t count) const {
  if (values == nullptr) return color;
  Color result{0, 0, 0, 255};
  for (std::size_t i = 0; i < 3; ++i) result[i] = to_byte(encoded(std::clamp(values[i] * factor[i], 0.0, 1.0)));
  if (!opaque) result[3] = to_byte((count > 3 ? values[3] : 1) * factor[3]);
  return result;
}

GltfLook gltf_look(const GltfDocument& document, std::size_t index) {
  const json& material = document.item("materials", index);
  GltfLook look;
  if (const json& name = document.part(material, "name"); name.is_string()) look.name = name.get<std::string>();
  const json& alpha_mode = document.part(material, "alphaMode");
  look.opaque = !alpha_mode.is_string() || alpha_mode.get_ref<const std::string&>() == "OPAQUE";
  if (alpha_mode == json("MASK")) look.cutoff = document.number(material, "alphaCutoff", 0.5);
  look.emits_image = document.part(material, "emissiveTexture").contains("index");
  const json& metallic = document.part(material, "pbrMetallicRoughness");
  const json& glossy = document.part(document.part(material, "extensions"), "KHR_materials_pbrSpecularGlossiness");
  const bool is_glossy = !metallic.contains("baseColorTexture") && !glossy.empty();
  const json& base = is_glossy ? glossy : metallic;
  const std::vector<double> factor =
      document.numbers(base, is_glossy ? "diffuseFactor" : "baseColorFactor", {1, 1, 1, 1});
  std::copy(factor.begin(), factor.end(), look.factor.begin());
  const float white[] = {1, 1, 1, 1};
  look.color = look.color_of(white, 4);
  read_texture(document, document.part(base, is_glossy ? "diffuseTexture" : "baseColorTexture"), look);
  return look;
}

Texture gltf_texture(GltfDocument& document, const GltfLook& look) {
  const json& image = document.item("images", look.image.value_or(0));
  const json& uri = document.part(image, "uri");
  const std::string name = fmt::format("{}:image {}", document.path().string(), look.image.value_or(0));
  Texture texture;
  if (!uri.is_string()) {
    const auto view = document.index(image, "bufferView");
    if (!view) document.fail(fmt::format("its image {} has no data", look.image.value_or(0)), kExportAnew);
    const std::string_view bytes = document.view(*view);
    texture = decode_texture(bytes.data(), bytes.size(), name);
  } else if (const auto bytes = document.embedded(uri.get<std::string>())) {
    texture = decode_texture(bytes->data(), bytes->size(), name);
  } else {
    texture = load_texture(find_texture(document.path(), uri.get<std::string>()));
  }
  const bool plain = std::all_of(look.factor.begin(), look.factor.end(), [](double f) { return f == 1; });
  std::array<std::array<std::uint8_t, 256>, 4> table{};
  for (std::size_t value = 0; value < 256; ++value) {
    const double share = static_cast<double>(value) / 255;
    for (std::size_t i = 0; i < 3; ++i)
      table[i][value] = to_byte(encoded(std::max(decoded(share) * look.factor[i], 0.0)));
    const double alpha = share * look.factor[3];
    table[3][value] = look.opaque ? 255 : to_byte(look.cutoff ? (alpha >= *look.cutoff ? 1 : 0) : alpha);
  }
  for (std::size_t i = 0; i < texture.rgba.size(); ++i) {
    const std::size_t channel = i % 4;
    if (channel == 3 || !plain) texture.rgba[i] = table[channel][texture.rgba[i]];
  }
  return texture;
}

}  // namespace holdfast::io
