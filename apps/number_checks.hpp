#pragma once

#include <CLI/CLI.hpp>
#include <cmath>
#include <string>

namespace holdfast::app {

/// CLI11's own checks of this kind name the range up to the largest number there is, in 309 digits.
inline CLI::Validator number_check(bool zero_is_one, const char* what, const char* type_name) {
  return {[zero_is_one, what](const std::string& text) {
            double value = 0;
            if (!CLI::detail::lexical_cast(text, value) || !std::isfinite(value)) {
              return "'" + text + "' is no number";
            }
            return value > 0 || (zero_is_one && value == 0) ? std::string() : text + " must be " + what;
          },
          type_name};
}

inline CLI::Validator positive_number() { return number_check(false, "more than 0", "POSITIVE"); }
inline CLI::Validator nonnegative_number() { return number_check(true, "at least 0", "NONNEGATIVE"); }

}  // namespace holdfast::app
