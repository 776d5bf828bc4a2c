#pragma once

#include <doctest/doctest.h>

#include "support/files.hpp"

/// That `action` throws an error of this code, in one line with all of the words that follow. The messages are part of
/// the interface: a failed check shows the one that came.
#define CHECK_ERROR(action, code, ...)                                                    \
  do {                                                                                    \
    const holdfast::test::CaughtError caught = holdfast::test::error_of([&] { action; }); \
    CAPTURE(caught.message);                                                              \
    CHECK(caught.says(code, {__VA_ARGS__}));                                              \
  } while (false)
