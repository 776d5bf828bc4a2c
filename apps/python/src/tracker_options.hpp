#pragma once

#include <array>
#include <string>
#include <utility>

#include "fields.hpp"
#include "holdfast/options.hpp"

/// The table of TrackerOptions: what keyword arguments of Tracker are called.
namespace holdfast {

template <class Options, class Visit>
requires std::is_same_v<std::remove_const_t<Options>, OcclusionOptions>
void for_each_field(Options& o, const Visit& visit) {
  visit("gradient_test", o.gradient_test);
  visit("angle_test", o.angle_test);
  visit("magnitude_test", o.magnitude_test);
  visit("block_vote", o.block_vote);
  visit("angle_together", o.angle_together);
  visit("gradient_minimum", o.gradient_minimum);
  visit("angle_maximum", o.angle_maximum);
  visit("difference_maximum", o.difference_maximum);
  visit("difference_relative", o.difference_relative);
  visit("vote_share", o.vote_share);
  visit("redundancy", o.redundancy);
  visit("redundancy_cosine", o.redundancy_cosine);
}

template <class Options, class Visit>
requires std::is_same_v<std::remove_const_t<Options>, TrackerOptions>
void for_each_field(Options& o, const Visit& visit) {
  visit("quality", o.quality);
  visit("levels", o.levels);
  visit("search_radius", o.search_radius);
  visit("contour", o.contour);
  visit("light_compensation", o.light_compensation);
  visit("motion_blur", o.motion_blur);
  visit("recovery", o.recovery);
  visit("recovery_budget_ms", o.recovery_budget_ms);
  visit("occlusion", o.occlusion);
  visit("ablate", o.ablate);
}

}  // namespace holdfast

namespace holdfast::python {

/// Words of a Quality.
template <>
struct FieldWords<Quality> {
  static constexpr std::array<std::pair<const char*, Quality>, 3> words{
      {{"accurate", Quality::accurate}, {"fast", Quality::fast}, {"paper", Quality::paper}}};
  static constexpr const char* expected = "accurate, fast or paper";
};

/// Options of a mode: "default", "fast" or "paper". Throws ValueError for another name.
TrackerOptions options_of_mode(const std::string& mode);

}  // namespace holdfast::python
