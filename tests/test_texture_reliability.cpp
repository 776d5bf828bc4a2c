// How much of what the texture says is believed.
#include <doctest/doctest.h>

#include "texture/texture_modality.hpp"

using holdfast::texture_reliability;

TEST_CASE("more that agrees, and agrees better, is believed more") {
  for (int i = 0; i < 100; ++i) {
    for (int j = 0; j < 100; ++j) {
      const double ratio = i / 100.0, correlation = j / 100.0;
      const double here = texture_reliability(ratio, correlation);
      CAPTURE(ratio);
      CAPTURE(correlation);
      CHECK(here >= 0);
      CHECK(here <= 1);
      CHECK(texture_reliability(ratio + 0.01, correlation) >= here);
      CHECK(texture_reliability(ratio, correlation + 0.01) >= here);
    }
  }
}

TEST_CASE("what passes by chance, or looks like something else, is not believed") {
  CHECK(texture_reliability(0, 1) == 0);
  CHECK(texture_reliability(0.05, 1) == 0);
  CHECK(texture_reliability(0.8, 0) == 0);
  CHECK(texture_reliability(0.8, -0.9) == 0);
  CHECK(texture_reliability(0.12, 0.5) < 0.2);
}

TEST_CASE("a printed object in the open is believed, and half of it behind something hardly less") {
  CHECK(texture_reliability(0.85, 0.98) > 0.9);
  CHECK(texture_reliability(1, 1) == doctest::Approx(1));
  CHECK(texture_reliability(0.4, 0.98) > 0.8 * texture_reliability(0.8, 0.98));
}
