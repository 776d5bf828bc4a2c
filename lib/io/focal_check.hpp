#pragma once

#include <optional>
#include <string>

#include "holdfast/camera.hpp"

namespace holdfast::io {

/// A warning where the focal length is no lens's for frames of the camera's size; nothing where it has no size.
std::optional<std::string> focal_warning(const Camera& camera);

}  // namespace holdfast::io
