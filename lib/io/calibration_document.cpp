#include "io/calibration_document.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <opencv2/core.hpp>

#include "holdfast/error.hpp"

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

json from_opencv(const cv::FileNode& node) {
  switch (node.type()) {
    case cv::FileNode::INT:
      return static_cast<int>(node);
    case cv::FileNode::REAL:
      return static_cast<double>(node);
    case cv::FileNode::STRING:
      return static_cast<std::string>(node);
    case cv::FileNode::SEQ: {
      json list = json::array();
      for (const cv::FileNode& child : node) {
        list.push_back(from_opencv(child));
      }
      return list;
    }
    case cv::FileNode::MAP: {
      json map = json::object();
      for (const cv::FileNode& child : node) {
        map[child.name()] = from_opencv(child);
      }
      return map;
    }
    default:
      return nullptr;
  }
}

json from_yaml(const YAML::Node& node) {
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
        list.push_back(from_yaml(child));
      }
      return list;
    }
    case YAML::NodeType::Map: {
      json map = json::object();
      for (const auto& entry : node) {
        map[entry.first.as<std::string>()] = from_yaml(entry.second);
      }
      return map;
    }
    default:
      return nullptr;
  }
}

json parse_xml(const std::string& text, const fs::path& path) {
  try {
    const cv::FileStorage storage(text, cv::FileStorage::READ | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_XML);
    return from_opencv(storage.root());
  } catch (const cv::Exception& error) {
    fail(path, "OpenCV XML", error.err);
  }
}

json parse_json(const std::string& text, const fs::path& path) {
  try {
    return json::parse(text);
  } catch (const json::exception& error) {
    fail(path, "JSON", error.what());
  }
}

/// OpenCV's own YAML reader takes nothing without OpenCV's header and is strict about layout, so that ROS files fail in
/// it; yaml-cpp reads both once OpenCV's "%YAML:1.0" (no YAML directive: the colon) is out of the way.
json parse_yaml(const std::string& text, const fs::path& path) {
  const std::size_t body = text.starts_with("%YAML:") ? std::min(text.find('\n'), text.size()) : 0;
  try {
    return from_yaml(YAML::Load(text.substr(body)));
  } catch (const YAML::Exception& error) {
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
