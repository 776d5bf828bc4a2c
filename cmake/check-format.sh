#!/bin/sh
# check-format.sh [--fix]: compares all C++ and OpenCL C files with .clang-format, or rewrites them.
set -eu
cd "$(dirname "$0")/.."
# Debian 12's version: others break some lines differently.
formatter=$(command -v clang-format-14 || command -v clang-format) ||
  { echo "clang-format is missing: make deps" >&2; exit 1; }
if ! "$formatter" --version | grep -q 'version 14\.'; then
  echo "The format is not checked: that needs clang-format 14, here is $("$formatter" --version)"
  exit 0
fi
mode="--dry-run --Werror"
if [ "${1:-}" = --fix ]; then
  mode=-i
fi
# shellcheck disable=SC2086
find include lib apps tests kernels \( -name '*.[ch]pp' -o -name '*.cl' -o -name shared.h \) -print0 | xargs -0 "$formatter" --style=file $mode ||
  { echo "Format differs from .clang-format: make format" >&2; exit 1; }
