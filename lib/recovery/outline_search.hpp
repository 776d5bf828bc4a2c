#pragma once

#include <vector>

#include "base/corner_motion.hpp"
#include "contour/color_histograms.hpp"
#include "image/depth_view.hpp"
#include "image/device_image.hpp"
#include "recovery/keyframes.hpp"

namespace holdfast {

/// Looks for a lost object without texture over the whole picture: where its colours are, as it looked while it was
/// held or turned from there; silhouettes that its colours fill and do not surround are worth a start. Proposes poses
/// to align from, decides nothing.
class OutlineSearch {
 public:
  OutlineSearch(const Device::Impl& device, const std::vector<Level>& levels, const Extent& extent, DeviceImage& image,
                DepthView& shape);

  void clear();
  /// The object was surely held at this pose.
  void remember(const Pose& T_camera_object) { keyframes_.remember(T_camera_object); }
  /// The object is held again: the next search begins anew.
  void end() { searching_ = false; }

  /// The best starts for this frame, of the next appearances of a plan that goes on from frame to frame; the whole
  /// picture must have been uploaded. `T_last`: where it was held last, `T_expected`: where it may have gone, `box`:
  /// pixels of the picture that it covered. Waits for the device.
  std::vector<Pose> starts(const Pose& T_last, const Pose& T_expected, const Rect& box, const ColorHistograms& colors);

 private:
  void read_colors(const ColorHistograms& colors);
  std::vector<Eigen::Vector2d> places(const Rect& box);
  /// What the pixels inside the silhouette say for the object, less what those around it say, means; -2 to 2.
  double contrast(const Pose& T_camera_object);
  double says(int x, int y) const {
    return static_cast<double>(
        says_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)]);
  }

  const Device::Impl& device_;
  const std::vector<Level>& levels_;
  Extent extent_;
  DeviceImage& image_;
  Keyframes keyframes_;
  DepthView& shape_;
  bool searching_ = false;
  int level_ = 0;  ///< that the picture is looked at on
  int width_ = 0, height_ = 0;
  std::vector<float> pixels_;
  std::vector<float> says_;   ///< what each pixel's colour says for the object, -1 to 1
  std::vector<double> sums_;  ///< these, summed up from the picture's corner
};

}  // namespace holdfast
