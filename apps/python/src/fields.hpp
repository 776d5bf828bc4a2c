#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <type_traits>
#include <vector>

/// Option structs as dictionaries. Each struct has one table, for_each_field(options, visit), that calls
/// `visit(name, field)` for its fields; a field that has such a table itself is a dictionary within the dictionary.
namespace holdfast::python {

namespace nb = nanobind;

/// Specialized for enumerations, which are words in Python: `words`, pairs of word and value, and `expected`, for
/// messages.
template <class T>
struct FieldWords;

template <class T>
concept HasWords = requires {
  FieldWords<T>::words;
};

template <class T>
constexpr const char* expected_type() {
  if constexpr (HasWords<T>) return FieldWords<T>::expected;
  if constexpr (std::is_same_v<T, std::vector<std::string>>) return "a list of str";
  if constexpr (std::is_same_v<T, bool>) return "True or False";
  if constexpr (std::is_integral_v<T>) return "a whole number";
  if constexpr (std::is_floating_point_v<T>) return "a number";
  return "a str or a path";
}

/// False when the value is of another type.
template <class T>
bool assign_field(T& field, nb::handle value) {
  if constexpr (std::is_same_v<T, bool>) {
    const std::string type = nb::cast<std::string>(nb::str(nb::handle(value.type()).attr("__name__")));
    if (type != "bool" && type != "bool_") return false;  // numpy's has either name
    field = nb::cast<bool>(nb::module_::import_("builtins").attr("bool")(value));
    return true;
  } else if constexpr (HasWords<T>) {
    std::string word;
    if (!nb::try_cast(value, word)) return false;
    for (const auto& [name, meaning] : FieldWords<T>::words) {
      if (word == name) {
        field = meaning;
        return true;
      }
    }
    return false;
  } else if constexpr (std::is_same_v<T, std::vector<std::string>>) {
    return !nb::isinstance<nb::str>(value) && nb::try_cast(value, field);
  } else if constexpr (std::is_arithmetic_v<T>) {
    if (nb::isinstance<nb::bool_>(value)) return false;
    return nb::try_cast(value, field, true);
  } else {
    std::string text;
    if (!nb::try_cast(nb::module_::import_("os").attr("fspath")(value), text)) return false;
    field = text;
    return true;
  }
}

template <class T>
concept HasFields = requires(T& options) {
  for_each_field(options, [](const char*, auto&) {});
};

/// Throws TypeError for a key that the struct has not, naming those it has, and for a value of another type.
template <class Options>
void set_fields(Options& options, const nb::dict& values) {
  for (auto [key, value] : values) {
    const std::string wanted = nb::cast<std::string>(nb::str(key));
    bool found = false;
    std::string names, group;
    for_each_field(options, [&](const char* name, auto& field) {
      using Field = std::remove_reference_t<decltype(field)>;
      names += (names.empty() ? "" : ", ") + std::string(name);
      if constexpr (HasFields<Field>) {
        for_each_field(field, [&](const char* inner, auto& /*value*/) {
          if (wanted == inner) group = name;
        });
      }
      if (wanted != name) return;
      found = true;
      if constexpr (HasFields<Field>) {
        if (!nb::isinstance<nb::dict>(value)) {
          throw nb::type_error(("option " + wanted + ": expected a dict").c_str());
        }
        set_fields(field, nb::cast<nb::dict>(value));
      } else if (!assign_field(field, value)) {
        throw nb::type_error(("option " + wanted + ": expected " + expected_type<Field>() + ", got " +
                              nb::cast<std::string>(nb::str(nb::repr(value))))
                                 .c_str());
      }
    });
    if (found) continue;
    if (!group.empty()) names += "; it is one of " + group + ": " + group + "={'" + wanted + "': ...}";
    throw nb::type_error(("there is no option '" + wanted + "'; there are: " + names).c_str());
  }
}

template <class Options>
nb::dict fields_dict(const Options& options) {
  nb::dict values;
  for_each_field(options, [&](const char* name, const auto& field) {
    using Field = std::remove_cvref_t<decltype(field)>;
    if constexpr (HasFields<Field>) {
      values[name] = fields_dict(field);
    } else if constexpr (HasWords<Field>) {
      for (const auto& [word, meaning] : FieldWords<Field>::words) {
        if (meaning == field) values[name] = nb::str(word);
      }
    } else if constexpr (std::is_same_v<Field, std::filesystem::path>) {
      values[name] = nb::str(field.c_str());
    } else {
      values[name] = nb::cast(field);
    }
  });
  return values;
}

}  // namespace holdfast::python
