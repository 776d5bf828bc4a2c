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

# The README's project, exactly as printed.
snippet() { awk -v language="$1" '$0 == "```" language { inside = 1; next } /^```$/ { inside = 0 } inside' "$source/../../README.md"; }
mkdir "$folder/readme"
snippet cmake >"$folder/readme/CMakeLists.txt"
snippet cpp >"$folder/readme/main.cpp"
grep -q 'add_executable' "$folder/readme/CMakeLists.txt"
grep -q 'int main' "$folder/readme/main.cpp"
cmake -S "$folder/readme" -B "$folder/readme/build" -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_PREFIX_PATH="$prefix"
cmake --build "$folder/readme/build"
