#pragma once

#include "image/device_image.hpp"
#include "image/view_template.hpp"

namespace holdfast {

/// How the strong gradients of the model's texture are found in the frame: light and shading make weak ones of their
/// own and hide such, but no print.
struct PrintAgreement {
  int usable = 0;          ///< pixels of the rendered view
  int pixels = 0;          ///< of these, with a strong gradient
  double correlation = 0;  ///< of the view's gradients and the frame's over these, [-1, 1]

  /// There is a print, and the frame does not show it.
  bool missing() const;
};

/// At the pose that the view was drawn at, on a level that it has; the frame must be blurred there. Reads both back and
/// waits for the device: for when it is in doubt, not for every frame.
PrintAgreement print_agreement(const Device::Impl& device, const ViewTemplate& view, const DeviceImage& image,
                               const Level& level);

}  // namespace holdfast
