#!/bin/sh
# with_pkg_config.sh PREFIX FOLDER CXX: builds the consumer's programs with pkg-config's flags alone, and runs them.
set -eu
prefix=$1 folder=$2 compiler=$3
source=$(cd "$(dirname "$0")" && pwd)
rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"
PKG_CONFIG_PATH=$(dirname "$(find "$prefix" -name holdfast.pc)")
export PKG_CONFIG_PATH
LD_LIBRARY_PATH=$(dirname "$PKG_CONFIG_PATH")
export LD_LIBRARY_PATH
# shellcheck disable=SC2046  # flags are words
"$compiler" -std=c++20 "$source/embed.cpp" $(pkg-config --cflags --libs holdfast) -o embed
./embed
# shellcheck disable=SC2046
"$compiler" -std=c++20 "$source/embed_io.cpp" $(pkg-config --cflags --libs holdfast-io) -o embed_io
./embed_io
