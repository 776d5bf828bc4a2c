#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "evaluation/protocol.hpp"
#include "evaluation/summary.hpp"

namespace holdfast::evaluation {

/// One sequence at one frame step, all offsets.
struct Evaluation {
  std::string sequence;
  int step = 1;
  std::vector<FrameRecord> records;
  Summary summary;
};

/// A line an evaluation, columns aligned, and a line of means where there are several.
std::string table(const std::vector<Evaluation>& evaluations, Protocol protocol);

/// Every frame of every evaluation as comma-separated values: lengths in millimetres, angles in degrees, poses in
/// metres and row-major 3x4. Throws Error(file).
void write_frames_csv(const std::filesystem::path& path, const std::vector<Evaluation>& evaluations);

}  // namespace holdfast::evaluation
