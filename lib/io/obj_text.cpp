#include "io/obj_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "io/model_fault.hpp"
#include "io/numbers.hpp"
#include "io/text_file.hpp"

namespace holdfast::io {
namespace {

namespace fs = std::filesystem;

class ObjParser {
 public:
  ObjParser(const fs::path& path, double scale) : path_(path), scale_(scale) {}

  ObjText parse() {
    const std::string bytes = read_text_file(path_, "model");
    std::string_view text = bytes;
    std::string joined;
    for (std::string_view line; next_line(text, line); ++line_) {
      joined.clear();
      while (line.ends_with('\\') && !text.empty()) {  // goes on in the next line
        joined.append(line.substr(0, line.size() - 1)).append(" ");
        next_line(text, line);
        ++line_;
      }
      if (!joined.empty()) {
        joined.append(line);
        line = joined;
      }
      parse_line(line);
    }
    const auto differs = [&](const auto& blue) { return blue.second != blues_.front().second; };
    if (weighted_ && std::ranges::any_of(blues_, differs)) take_weights_off();  // alpha is mostly the same everywhere
    return std::move(read_);
  }

 private:
  template <class... Advice>
  [[noreturn]] void fail(const std::string& reason, const Advice&... advice) const {
    fail_model(path_, fmt::format("line {}: {}", line_, reason), advice...);
  }

  void parse_line(std::string_view line) {
    const std::string keyword = lower(next_word(line));
    if (keyword == "v") {
      add_position(line);
    } else if (keyword == "vt") {
      const std::size_t count = numbers(line.substr(0, line.find('#')), 3);
      if (count == 0) fail("a texture coordinate without numbers");
      read_.coordinates.push_back({static_cast<float>(values_[0]), count > 1 ? static_cast<float>(values_[1]) : 0.0F});
    } else if (keyword == "f" || keyword == "fo") {
      add_face(line.substr(0, line.find('#')));
    } else if (keyword == "usemtl") {
      use(std::string(trimmed(line)));
    } else if (keyword == "mtllib") {
      read_.libraries.emplace_back(trimmed(line));
    }
  }

  std::size_t numbers(std::string_view line, std::size_t most) {
    std::size_t count = 0;
    for (std::string_view word = next_word(line); !word.empty() && count < most; word = next_word(line)) {
      const std::optional<double> number = parse_number(word);
      if (!number) fail(fmt::format("'{}' is not a number", word.substr(0, 20)), advice_on_number(word));
      values_[count++] = *number;
    }
    return count;
  }

  /// x y z, then nothing, a weight, or a colour, with a weight before it or alpha after it.
  void add_position(std::string_view line) {
    const std::size_t count = numbers(line.substr(0, line.find('#')), 7);
    if (count < 3) fail(fmt::format("a vertex of {} numbers", count));
    const double weight = count == 4 && values_[3] != 0 ? values_[3] : 1;
    read_.positions.push_back((Eigen::Vector3d(values_[0], values_[1], values_[2]) * (scale_ / weight)).cast<float>());
    if (count < 6 && read_.colors.empty()) return;
    read_.colors.resize(read_.positions.size(), Eigen::Array4f::Zero());
    if (count < 6) return;
    read_.colors.back() << static_cast<float>(values_[3]), static_cast<float>(values_[4]),
        static_cast<float>(values_[5]), 1;
    if (count < 7) return;
    blues_.emplace_back(read_.colors.size() - 1, static_cast<float>(values_[6]));
    weighted_ = weighted_ && values_[3] == 1;
  }

  /// The colours of vertices of seven numbers, where the fourth is a weight.
  void take_weights_off() {
    for (const auto& [index, blue] : blues_) {
      Eigen::Array4f& color = read_.colors[index];
      color << color[1], color[2], blue, 1;
    }
  }

  /// The index that a corner names, from 1 or, below 0, from the last on; nothing where it names none.
  std::optional<std::size_t> index(std::string_view word, std::size_t count, const char* what) const {
    if (word.empty()) return std::nullopt;
    const std::optional<double> number = parse_number(word);
    if (!number || *number != std::floor(*number)) {
      fail(fmt::format("'{}' is no corner of a face", word.substr(0, 20)));
    }
    const double from_zero = *number < 0 ? static_cast<double>(count) + *number : *number - 1;
    if (!(from_zero >= 0 && from_zero < static_cast<double>(count))) {
      fail(fmt::format("a face refers to {} {}, but there are {}", what, *number, count));
    }
    return static_cast<std::size_t>(from_zero);
  }

  void add_face(std::string_view line) {
    ObjFace face{read_.corners.size(), 0, material_, true};
    for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
      const std::size_t slash = std::min(word.find('/'), word.size());
      const auto position = index(word.substr(0, slash), read_.positions.size(), "vertex");
      if (!position) fail(fmt::format("'{}' is no corner of a face", word.substr(0, 20)));
      std::string_view second = word.substr(std::min(slash + 1, word.size()));
      second = second.substr(0, second.find('/'));
      const auto coordinate = index(second, read_.coordinates.size(), "texture coordinate");
      face.textured = face.textured && coordinate.has_value();
      read_.corners.push_back({*position, coordinate.value_or(kNone)});
      ++face.count;
    }
    read_.faces.push_back(face);
  }

  void use(const std::string& name) {
    const auto [known, is_new] = materials_.try_emplace(name, read_.material_names.size());
    if (is_new) read_.material_names.push_back(name);
    material_ = known->second;
  }

  const fs::path& path_;
  double scale_;
  int line_ = 1;
  std::array<double, 7> values_{};
  std::map<std::string, std::size_t> materials_;
  std::size_t material_ = kNone;
  std::vector<std::pair<std::size_t, float>> blues_;  ///< the last of seven numbers, by position
  bool weighted_ = true;                              ///< the fourth of seven is 1 everywhere
  ObjText read_;
};

}  // namespace

ObjText parse_obj(const fs::path& path, double scale) { return ObjParser(path, scale).parse(); }

}  // namespace holdfast::io
