// Whether what blurs the frames is motion: views blurred along it and across it, beside sharp ones.
#include <doctest/doctest.h>

#include "imaging/imaging_state.hpp"

namespace {

using holdfast::BlurDirections;

BlurDirections after(int frames, double sharp, double along, double across) {
  BlurDirections directions;
  for (int i = 0; i < frames; ++i) directions.add(sharp, along, across);
  return directions;
}

}  // namespace

TEST_CASE("blur that is better along the motion, and worse across it, is motion's") {
  CHECK(after(1, 0.25, 0.69, 0.29).along_motion());
  CHECK(after(5, 0.78, 0.8, 0.76).along_motion());
}

TEST_CASE("blur that is as good across the motion is not motion's") {
  CHECK_FALSE(after(1, 0.53, 0.58, 0.58).along_motion());
  CHECK_FALSE(after(5, 0.54, 0.585, 0.592).along_motion());
  CHECK_FALSE(BlurDirections().along_motion());
}

TEST_CASE("a fast frame says more than slow ones, and what was long ago counts for less") {
  BlurDirections directions = after(3, 0.5, 0.51, 0.51);
  directions.add(0.2, 0.7, 0.3);
  CHECK(directions.along_motion());
  for (int i = 0; i < 40; ++i) directions.add(0.5, 0.55, 0.55);
  CHECK_FALSE(directions.along_motion());
}

TEST_CASE("blur that leaves nothing that fits is no error") {
  CHECK(after(1, 0.5, 0.6, 0).along_motion());
  CHECK_FALSE(after(1, 0, 0, 0).along_motion());
}
