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
  std::string model;    ///< the model's file; empty: none
  double diameter = 0;  ///< of the model, metres; 0: no model
  int step = 1;
  std::vector<FrameRecord> records;
  Summary summary;
};

/// How evaluations were made, for the reader of a report.
struct Provenance {
  std::string protocol = {};  ///< "never-reset", "rbot" or "poses"
  Tolerance failure = tolerance_mm_deg(50, 5);
  double minimum_visible = 0;
  bool show_start_frame = true;
  std::string tracker = {};  ///< device and renderer in words, or the file of poses
  bool complete = true;      ///< false: interrupted, so that frames, steps or sequences are missing
};

/// A line an evaluation, columns aligned, and a line of means where there are several sequences. The rbot protocol has
/// columns of its own: medians over the frames that did not fail.
std::string table(const std::vector<Evaluation>& evaluations, bool rbot);

/// The rest of the figures in the same form: ADD and ADD-S, depth and lateral errors, coverage, and
/// (not for rbot, whose resets end them) losses and how long they lasted.
std::string detail_table(const std::vector<Evaluation>& evaluations, bool rbot);

/// Every frame of every evaluation as comma-separated values: lengths in millimetres, angles in degrees, poses in
/// metres and row-major 3x4. Throws Error(output).
void write_frames_csv(const std::filesystem::path& path, const std::vector<Evaluation>& evaluations);

/// All figures and the errors of every frame. Lengths in millimetres, angles in degrees, shares from 0 to 1; null where
/// there is no figure. Throws Error(output).
void write_json(const std::filesystem::path& path, const Provenance& provenance,
                const std::vector<Evaluation>& evaluations);

}  // namespace holdfast::evaluation
