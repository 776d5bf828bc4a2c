#include "modules/load_module.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include "holdfast/error.hpp"

namespace holdfast::app {

const void* load_module(const std::string& name, const std::string& purpose) {
  const std::string symbol = "holdfast_" + name;
  void* module = dlopen((symbol + ".so").c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  const void* functions = module != nullptr ? dlsym(module, symbol.c_str()) : nullptr;
  if (functions == nullptr) {
    throw Error(ErrorCode::file,
                fmt::format("{} by a part of the program that cannot be loaded: {}; install Holdfast again, the whole "
                            "of it",
                            purpose, dlerror()));
  }
  return functions;
}

}  // namespace holdfast::app
