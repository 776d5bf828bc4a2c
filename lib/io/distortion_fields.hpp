#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "holdfast/camera.hpp"

namespace holdfast::io {

/// Reads the lens distortion of a calibration into a camera whose lens is known; none where the file names none.
/// Throws Error(camera) for coefficients that its lens does not have, and for distortion under an unknown name.
void read_distortion(Camera& camera, const nlohmann::json& document, const std::filesystem::path& path);

}  // namespace holdfast::io
