#include "io/calibration_document.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <stdexcept>

#include "holdfast/error.hpp"
#include "io/json_text.hpp"
#include "io/xml_text.hpp"

namespace holdfast::io {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const char* syntax, std::string reason) {
  std::replace(reason.begin(), reason.end(), '\n', ' ');
  throw Error(ErrorCode::camera,
              fmt::format("camera file '{}' is no valid {} ({}): correct it, or give 'fx fy cx cy' as text",
                          path.string(), syntax, reason));
}

/// A tree of YAML with its aliases written out: a few bytes of them may stand for any number of values.
class YamlReader {
 public:
  json read(const YAML::Node& node, int depth = 0) {
    if (depth > kMostNested) throw std::runtime_error("its lists and maps are nested too deeply");
    if (++values_ > kMostValues) throw std::runtime_error("it holds more than 100000 values");
    switch (node.Type()) {
      case YAML::NodeType::Scalar: {
        double number = 0;
        if (node.Tag() != "!" && YAML::convert<double>::decode(node, number)) {  // "!": a quoted string
          return number;
        }
        return node.Scalar();
      }
      case YAML::NodeType::Sequence: {
        json list = json::array();
        for (const YAML::Node& child : node) {
          list.push_back(read(child, depth + 1));
        }
        return list;
      }
      case YAML::NodeType::Map: {
        json map = json::object();
        for (const auto& entry : node) {
          map[entry.first.as<std::string>()] = read(entry.second, depth + 1);
        }
        return map;
      }
      default:
        return nullptr;
    }
  }

 private:
  static constexpr int kMostValues = 100'000;
  int values_ = 0;
};

json parse_xml(const std::string& text, const fs::path& path) {
  try {
    return parse_xml_text(text);
  } catch (const std::runtime_error& error) {
    fail(path, "OpenCV XML", error.what());
  }
}

json parse_json(const std::string& text, const fs::path& path) {
  try {
    return parse_json_text(text);
  } catch (const std::runtime_error& error) {
    fail(path, "JSON", error.what());
  }
}

/// OpenCV's own YAML reader takes nothing without OpenCV's header and is strict about layout, so that ROS files fail in
/// it; yaml-cpp reads both once OpenCV's "%YAML:1.0" (no YAML directive: the colon) is out of the way.
json parse_yaml(const std::string& text, const fs::path& path) {
  const std::size_t body = text.starts_with("%YAML:") ? std::min(text.find('\n'), text.size()) : 0;
  try {
    return YamlReader().read(YAML::Load(text.substr(body)));
  } catch (const std::runtime_error& error) {  // YAML's exceptions too
    fail(path, "YAML", error.what());
  }
}

}  // namespace

json parse_calibration(const std::string& text, const fs::path& path) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && text[first] == '<') {
    return parse_xml(text, path);
  }
  if (first != std::string::npos && text[first] == '{') {
    return parse_json(text, path);
  }
  return parse_yaml(text, path);
}

}  // namespace holdfast::io
