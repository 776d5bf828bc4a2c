#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>

#include "holdfast/pose.hpp"

namespace holdfast::evaluation {

/// Throws Error(file): the file and what is wrong with it.
[[noreturn]] void bad_file(const std::filesystem::path& path, const std::string& what);

/// The pose as an exact rotation. Throws Error(pose), with the place it stands at, for what is no rotation at all.
Pose checked(const Pose& pose, const std::filesystem::path& path, const std::string& where);

/// Over the mark that Windows' programs begin UTF-8 with.
void skip_byte_order_mark(std::istream& file);

}  // namespace holdfast::evaluation
