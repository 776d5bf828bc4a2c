#include "modules/window_module.hpp"

#include "modules/load_module.hpp"

namespace holdfast::app {

const WindowModule& window_module() {
  return *static_cast<const WindowModule*>(load_module("window", "windows are shown"));
}

}  // namespace holdfast::app
