#pragma once

namespace holdfast::app {

/// Loads OpenCL's drivers. Called before any thread is begun: PoCL changes the environment then, which no other thread
/// may read at that time. Where PoCL's cache cannot be written, a folder for temporary files takes its place, with a
/// warning.
void start_drivers();

}  // namespace holdfast::app
