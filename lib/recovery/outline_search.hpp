#pragma once

#include <cstdint>
#include <vector>

#include "base/corner_motion.hpp"
#include "contour/color_histograms.hpp"
#include "edges/model_edges.hpp"
#include "image/depth_view.hpp"
#include "image/device_image.hpp"
#include "recovery/direction_responses.hpp"
#include "recovery/keyframes.hpp"
#include "recovery/relocalizer.hpp"

namespace holdfast {

/// A point of an outline: pixels from the projection of the object's centre, and the direction of its normal, radians.
struct OutlinePoint {
  float x = 0, y = 0;
  float normal = 0;      ///< of a contour out of the object
  bool contour = false;  ///< else an edge within it
  Eigen::Vector3f p_camera = Eigen::Vector3f::Zero();
};

/// Looks for a lost object by its outline over the whole picture: contours and edges of views around the last that it
/// was held in, of others that it was held in, and after a while of all sides, shifted over the frame's gradients and
/// the colours that belong to the object (equation 38 of docs/math.md). Proposes poses to align from, decides nothing.
class OutlineSearch {
 public:
  OutlineSearch(const Device::Impl& device, const std::vector<Level>& levels, const Extent& extent,
                const std::vector<EdgeSample>& samples, DeviceImage& image, DepthView& shape);

  void clear();
  /// The object was surely held at this pose.
  void remember(const Pose& T_camera_object) { keyframes_.remember(T_camera_object); }
  /// The object is held again: the next search begins anew.
  void end() { searching_ = false; }

  /// The best starts for this frame, of the next part of a plan that goes on from frame to frame, as much of it as so
  /// many nominal milliseconds allow; the whole picture must have been uploaded. `T_last`: where it was held last;
  /// `all_sides`: it may show any by now. Waits for the device.
  std::vector<Pose> starts(const Pose& T_last, const ColorHistograms& colors, double budget_ms, bool all_sides);

 private:
  /// The object as it may look, its centre on the optical axis; points are those at the middle distance.
  struct View {
    Pose T_camera_object;
    std::vector<OutlinePoint> points;
    bool drawn = false;
  };
  /// A view turned about the optical axis, nearer or farther.
  struct Template {
    std::size_t view = 0;
    double twist = 0;
    double distance = 1;
    double turn = 0;  ///< from where it was held last, about
  };
  struct Peak {
    double score = 0;
    Template shown;
    Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< of the object's centre, pixels of the level
  };

  /// Templates are tried in this order, again and again.
  struct Plan {
    std::vector<View> views;
    std::vector<Template> templates;
    std::size_t next = 0;
    /// Turned about the optical axis by so many steps either way; `swing`: from where it was held last.
    void add(const Pose& T_view, double swing, int twists, double step);
  };

  void plan(const Pose& T_last);
  void draw(View& view);
  void read_frame(const ColorHistograms& colors);
  /// The place where a template agrees best, by each so many-th of its points.
  Peak best_place(const Template& shown, std::size_t each);
  Pose pose_at(const Peak& peak) const;
  /// The pose around a peak's at which most of its points agree.
  PoseCandidate refined(const Peak& peak) const;
  /// How well the points of a view agree where a pose near it puts them.
  double agreement(const View& view, const Pose& T_camera_object) const;

  const Device::Impl& device_;
  const std::vector<Level>& levels_;
  Extent extent_;
  const std::vector<EdgeSample>& samples_;
  DeviceImage& image_;
  DepthView& shape_;
  Keyframes keyframes_;
  Plan around_, all_sides_;  ///< of where it was held last
  Plan* tried_ = &around_;   ///< in this frame
  int frames_ = 0;           ///< of this search
  bool searching_ = false;
  int level_ = 0;  ///< that the picture is looked at on
  DirectionResponses responses_;
  std::vector<float> pixels_, says_;
  std::vector<std::uint16_t> sums_;
};

}  // namespace holdfast
