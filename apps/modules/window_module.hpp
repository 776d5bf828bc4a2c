#pragma once

#include <opencv2/core.hpp>
#include <opencv2/highgui.hpp>
#include <string>

namespace holdfast::app {

/// The functions of OpenCV's highgui that show windows: it brings a window toolkit, which nothing else needs.
struct WindowModule {
  void (*named_window)(const std::string& title, int flags);
  void (*resize_window)(const std::string& title, int width, int height);
  void (*set_mouse_callback)(const std::string& title, cv::MouseCallback on_mouse, void* data);
  void (*show)(const std::string& title, cv::InputArray picture);
  int (*wait_key)(int milliseconds);
  double (*window_property)(const std::string& title, int property);
  void (*destroy_all_windows)();
};

/// Throws Error(file) when it cannot be loaded.
const WindowModule& window_module();

}  // namespace holdfast::app
