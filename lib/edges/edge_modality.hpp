#pragma once

#include <vector>

#include "edges/edge_candidates.hpp"
#include "edges/edge_memory.hpp"
#include "edges/visible_edges.hpp"
#include "image/depth_view.hpp"
#include "solve/normal_equations.hpp"

namespace holdfast {

/// What the edges of the model say of a pose.
struct EdgeTerms {
  bool found = false;  ///< enough edges are in the picture
  NormalEquations equations;
  double lines = 0;     ///< on the frame
  double near = 0;      ///< of these, with the most telling edge of the line next to the model's
  double variance = 0;  ///< of the rows' residuals, square pixels of the level

  /// Share of near lines beside what chance makes of it: at most 1, about 0 on any other picture.
  double score() const;
};

/// Closeness of the search for edges: pixels of the level from the model's edge at which one of the frame weighs 0.6
/// of one there.
inline constexpr double kCoarseEdgeSearch = 3, kCloseEdgeSearch = 1.5, kClosestEdgeSearch = 1.2;

/// The model's edges as a modality: creases and borders that are seen at a pose, the frame's edges along lines across
/// them, and a row a line (equations 32 to 36 of docs/math.md). Keeps no pose: its lines are a cache of the frame at
/// hand.
class EdgeModality {
 public:
  EdgeModality(const Device::Impl& device, const std::vector<Level>& levels, const Extent& extent, const Mesh& mesh,
               DepthView& shape, DeviceImage& image);

  /// Whether the model has edges to go by.
  bool has_edges() const { return !samples_.empty(); }
  /// Places on the model's edges.
  const std::vector<EdgeSample>& samples() const { return samples_; }
  void start_frame() { level_ = -1; }
  /// What is known of how the edges look before any frame.
  EdgeMemory no_memory() const;

  /// Rows and their normal equations at this pose on a level, looked for so closely; `memory`: what edges look like.
  EdgeTerms linearize(const Pose& T_camera_object, int level, double window, const EdgeMemory& memory);

  /// Share of the lines at a pose that see an edge which goes on along the model's, wherever it is on them: noise has
  /// few.
  double coherence(const Pose& T_camera_object, int level);

  /// Adds how the edges look at this pose to `memory`, which began as no_memory().
  void learn(const Pose& T_camera_object, int finest, EdgeMemory& memory);

 private:
  /// What a line tells: what is left of its information where one of its edges may be the model's, how far that is from
  /// where it is expected, pixels, and whether its most telling edge is next to that.
  struct Found {
    double weight = 0, offset = 0;
    bool near = false;
  };

  bool look(const Pose& T_camera_object, int level, const EdgeMemory& memory);
  void support();
  Found found_on(std::size_t line, double expected, double window) const;
  double usual_offset(const VisibleEdge& edge, int level, const EdgeMemory& memory) const;
  double displacement(const VisibleEdge& edge, const Pose& D, const Camera& camera) const;

  const std::vector<Level>& levels_;
  Extent extent_;
  std::vector<EdgeSample> samples_;
  DepthView& shape_;
  DeviceImage& image_;
  EdgeCandidates candidates_;
  std::vector<VisibleEdge> edges_;  ///< a line each
  std::vector<float> support_;      ///< weight of each candidate with its neighbours'
  Pose T_lines_ = Pose::Identity();
  int level_ = -1;  ///< of the lines; none
};

}  // namespace holdfast
