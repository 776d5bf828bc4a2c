#pragma once

#include <filesystem>
#include <string>

#include "track/output_file.hpp"
#include "track/run_summary.hpp"
#include "track/tracked_frame.hpp"

/// Pose files. Each constructor creates its file, each write() leaves it complete up to that frame; all throw
/// Error(output). Poses are T_camera_object, metres; quaternions have qw >= 0.
namespace holdfast::app {

/// A header, then one row a frame, lost ones too (their pose is the tracker's last guess):
/// frame, time_s, status (held, lost), tx ty tz, qx qy qz qw, pixel counts, residual, correlation, iterations, ms,
/// reason, texture_holds, contour_holds, snapshot_holds (0, 1).
class CsvWriter {
 public:
  explicit CsvWriter(const std::filesystem::path& path);
  void write(const TrackedFrame& tracked);

 private:
  OutputFile file_;
};

/// "time_s tx ty tz qx qy qz qw", one line a frame that is held: the format has no place for a status, and its readers
/// match by time.
class TumWriter {
 public:
  explicit TumWriter(const std::filesystem::path& path);
  void write(const TrackedFrame& tracked);

 private:
  OutputFile file_;
};

/// One JSON object: what was run, "frames" (all that the CSV has, times a stage and the information matrix), and at
/// the end "summary". The closing brackets are written after every frame and overwritten by the next, so that the file
/// is valid JSON whenever the run ends, also because the disk is full; only into a pipe they come at the end alone.
class JsonWriter {
 public:
  /// `run`: input, model and so on, a JSON object's text.
  JsonWriter(const std::filesystem::path& path, const std::string& run);
  void write(const TrackedFrame& tracked);
  void finish(const RunSummary& summary);

 private:
  void append(const std::string& text, const std::string& closing);

  OutputFile file_;
  long end_ = 0;         // where the closing brackets begin
  std::string closing_;  // that stand there
  bool first_ = true;
};

}  // namespace holdfast::app
