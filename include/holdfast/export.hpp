#pragma once

/// Marks what the shared libraries show; everything else in them is hidden. Without effect on a caller.
#if defined(__GNUC__)
#define HOLDFAST_EXPORT __attribute__((visibility("default")))
#else
#define HOLDFAST_EXPORT
#endif
