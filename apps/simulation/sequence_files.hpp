#pragma once

#include <filesystem>
#include <functional>

#include "simulation/sequence.hpp"

namespace holdfast::simulation {

struct SequenceFileOptions {
  bool masks = false;                         ///< occluder masks too
  bool overwrite = false;                     ///< replace a sequence that the folder already holds
  int threads = 0;                            ///< frames drawn at a time; 0: one a processor core
  std::function<bool()> is_interrupted = {};  ///< may be empty; asked before frames are drawn, true ends the sequence
};

/// Writes a sequence to a folder: frames/%06d.png (.jpg where compression is asked for), K.txt (fx fy cx cy),
/// poses_gt.txt (a line a frame: 3x4 row-major object-to-camera), visible.txt (visible share a frame), for distorting
/// lenses camera.yml, and masks/%06d.png (occluder in white) where wanted. The same files whatever `threads` is. Lines
/// and frames are complete up to the frame where writing stops. `after_frame` is called with each frame's index.
/// Returns how many frames were written.
/// Throws Error(output) when the folder holds a sequence already or a file cannot be written.
int write_sequence(const Sequence& sequence, const std::filesystem::path& folder, const SequenceFileOptions& options,
                   const std::function<void(int, const SimulatedFrame&)>& after_frame = {});

}  // namespace holdfast::simulation
