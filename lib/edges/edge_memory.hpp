#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace holdfast {

/// How the edges of a model have looked, one of them an EdgeSample: the step of colour across it. A value.
struct EdgeMemory {
  struct Look {
    Eigen::Vector3f step = Eigen::Vector3f::Zero();
    float offset = 0;        ///< pixels of the frame from the model's edge, along its normal, to what is seen beside it
    std::uint8_t faces = 0;  ///< bits of the faces that were seen then: 1, 2; 0: it was never seen
  };
  std::vector<Look> looks;  ///< empty: none
  /// The model's edges are not where the frame's are: what is seen beside them stands for them.
  bool off_model = false;
};

}  // namespace holdfast
