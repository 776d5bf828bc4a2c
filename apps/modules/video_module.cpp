#include "modules/video_module.hpp"

#include "modules/load_module.hpp"

namespace holdfast::app {

const VideoModule& video_module() {
  return *static_cast<const VideoModule*>(load_module("video", "videos and cameras are read and written"));
}

}  // namespace holdfast::app
