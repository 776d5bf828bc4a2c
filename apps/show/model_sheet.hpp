#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "holdfast/mesh.hpp"
#include "holdfast/renderer_choice.hpp"

namespace holdfast::app {

/// The model as it was loaded, seen along each of its axes from both sides, with its axes and its size. Surface without
/// a known look is grey, lit from the viewer. Throws Error(renderer).
cv::Mat model_sheet(const Mesh& mesh, const std::string& name, RendererChoice choice = RendererChoice::automatic);

/// A picture with the model's sheet at its right, as high as the picture.
cv::Mat with_model_sheet(const cv::Mat& picture, const Mesh& mesh, const std::string& name);

/// A doubt, in one sentence, about a closed model whose faces all look inwards, as those of a mirrored one do.
std::optional<std::string> model_doubt(const Mesh& mesh);

/// Size, triangles, materials and what share of the surface they give a look, in lines.
std::string model_text(const Mesh& mesh);

}  // namespace holdfast::app
