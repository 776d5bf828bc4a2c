#pragma once

#include <filesystem>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace holdfast::io {

/// Throws Error(camera), which names the file.
[[noreturn]] void fail_camera(const std::filesystem::path& path, const std::string& reason);

/// cameraMatrix, camera_matrix, Camera_Matrix: all the same.
std::string plain_key(const std::string& name);

/// The first field with one of these plain names, or null.
const nlohmann::json* find_field(const nlohmann::json& document, std::initializer_list<std::string_view> names);

/// The numbers of a matrix, row by row: {rows, cols, data: [...]}, nested lists, or one list. Throws Error(camera).
std::vector<double> matrix_values(const nlohmann::json& node, const std::filesystem::path& path,
                                  const std::string& name);

/// Throws Error(camera) where it is none.
double number_of(const nlohmann::json& node, const std::filesystem::path& path, const std::string& name);

}  // namespace holdfast::io
