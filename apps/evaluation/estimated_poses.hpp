#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "holdfast/frame_result.hpp"

namespace holdfast::evaluation {

/// Poses as a program wrote them: the table of `holdfast track` (columns frame, status, tx ty tz qx qy qz qw), or text
/// with a pose a line (12 or 16 numbers, or TUM).
struct EstimatedPoses {
  struct Entry {
    int frame = 0;
    FrameResult result;  ///< as far as the file tells; held where it does not

    bool held() const { return result.status == Status::held; }
  };
  std::vector<Entry> entries;  ///< by rising frame
};

/// Times of TUM lines tell the frame where `frame_rate` (frames a second) is given, unless all are whole numbers, which
/// are taken for frames themselves; otherwise a line is a frame. Throws Error(file) or Error(pose).
EstimatedPoses load_estimated_poses(const std::filesystem::path& file, std::optional<double> frame_rate);

}  // namespace holdfast::evaluation
