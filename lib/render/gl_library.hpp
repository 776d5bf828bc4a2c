#pragma once

#include <dlfcn.h>

#include <initializer_list>
#include <string>

namespace holdfast {

/// Opens the first of these libraries that there is, its names to itself, for the rest of the process: drivers have
/// threads that outlive contexts. Throws Error(renderer) with what the loader says of the first.
void* open_gl_library(std::initializer_list<const char*> names);

[[noreturn]] void fail_context(const std::string& message);

/// A function's address. Throws Error(renderer) where the library lacks it.
template <typename Function>
Function required_symbol(void* library, const char* name) {
  void* address = dlsym(library, name);
  if (address == nullptr) fail_context(std::string("it has no ") + name);
  return reinterpret_cast<Function>(address);
}

}  // namespace holdfast
