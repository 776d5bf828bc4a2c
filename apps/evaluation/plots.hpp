#pragma once

#include <filesystem>
#include <string>

namespace holdfast::evaluation {

/// Throws Error(invalid_argument) with what to install when `python` or its matplotlib is missing.
void require_plotting(const std::string& python = "python3");

/// Draws a report (write_json()) as PNG files into an existing folder, with evaluation/plot.py: errors over time for
/// each sequence and step, and accuracy over threshold for all. Throws Error(output) when the script fails.
void draw_plots(const std::filesystem::path& report, const std::filesystem::path& folder,
                const std::string& python = "python3");

}  // namespace holdfast::evaluation
