#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <opencv2/core.hpp>
#include <utility>

#include "track/overlay.hpp"
#include "track/tracked_frame.hpp"

namespace holdfast::app {

/// A window that shows tracked frames while they come. Pictures are drawn by the thread that writes; the window, which
/// toolkits want in the program's first thread, and its keys belong to the one that tracks.
class LiveWindow {
 public:
  /// `frame_rate`: frames a second that a recording is shown at, at most; 0: as they come. Throws Error(renderer,
  /// model, invalid_argument).
  LiveWindow(const Mesh& mesh, const Camera& camera, double frame_rate);
  ~LiveWindow();

  /// Draws a frame; any thread, one at a time.
  void draw(const TrackedFrame& tracked);

  /// Shows what was drawn last and obeys keys; waits while it is paused, or a frame comes before its time. Ends at once
  /// where `interrupted`.
  void update(const std::function<bool()>& interrupted);

  /// The user wants to end, by a key or by closing the window.
  bool quits() const { return quits_; }
  /// Whether the object is to be looked for again; once for each time that it was asked for.
  bool take_look_again() { return std::exchange(look_again_, false); }

 private:
  void obey(int key);
  void show();
  void save();

  Overlay overlay_;
  std::chrono::duration<double> least_time_;
  std::chrono::steady_clock::time_point last_, last_drawn_;
  double rate_ = 0;  ///< frames a second, running mean
  std::mutex mutex_;
  cv::Mat drawn_;  ///< by the writing thread
  std::int64_t drawn_frame_ = 0;
  bool fresh_ = false;
  cv::Mat shown_;
  std::int64_t shown_frame_ = 0;
  std::atomic<bool> decisions_ = false;
  bool paused_ = false, step_ = false, quits_ = false, look_again_ = false;
};

}  // namespace holdfast::app
