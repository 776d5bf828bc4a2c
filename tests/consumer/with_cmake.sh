#!/bin/sh
# with_cmake.sh PREFIX FOLDER CXX: builds the consumer in FOLDER against the tree installed in PREFIX, and runs it.
set -eu
prefix=$1 folder=$2 compiler=$3
source=$(cd "$(dirname "$0")" && pwd)
rm -rf "$folder"

# The core must not ask for the io target's dependencies.
cmake -S "$source" -B "$folder/core" -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_PREFIX_PATH="$prefix" -DWITH_IO=OFF \
  -DCMAKE_DISABLE_FIND_PACKAGE_OpenCV=ON -DCMAKE_DISABLE_FIND_PACKAGE_assimp=ON -DCMAKE_DISABLE_FIND_PACKAGE_fmt=ON \
  -DCMAKE_DISABLE_FIND_PACKAGE_yaml-cpp=ON -DCMAKE_DISABLE_FIND_PACKAGE_nlohmann_json=ON
cmake --build "$folder/core"
"$folder/core/embed"

cmake -S "$source" -B "$folder/io" -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_PREFIX_PATH="$prefix"
cmake --build "$folder/io" --target embed_io
cd "$folder/io" && ./embed_io
