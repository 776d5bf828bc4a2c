#pragma once

#include "arrays.hpp"
#include "holdfast/mesh.hpp"

namespace holdfast::python {

/// A copy of an image: HxWx3 RGB, HxWx4 RGBA or HxW grey, uint8.
Texture texture_argument(nb::handle value, const char* name);

}  // namespace holdfast::python
