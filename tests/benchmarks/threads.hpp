#pragma once

namespace holdfast::bench {

/// Takes "--threads N" (2 without it) from the arguments and lets the process use so many: for OpenCL, drawing and
/// OpenCV, and as many cores. Before anything of these is used: PoCL and Mesa read their number once.
/// Throws Error(invalid_argument).
int use_threads(int& argc, char** argv);

}  // namespace holdfast::bench
