#pragma once

#include <vector>

#include "holdfast/camera.hpp"
#include "holdfast/pose.hpp"
#include "support/files.hpp"

namespace holdfast::test {

inline const Camera kSmallCamera{320, 240, 325, 325, 159.5, 119.5, {}};

/// What `track` reads, written to a folder: frames/0.png and on, of a printed box that moves by up to `speed` pixels a
/// frame, box.obj, camera.yml and first.txt, the first frame's pose. Returns the true poses.
std::vector<Pose> write_small_sequence(const TemporaryFolder& folder, int frames, double speed = 2);

}  // namespace holdfast::test
