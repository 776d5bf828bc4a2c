#!/bin/sh
# documents.sh PREFIX FOLDER CXX CC: builds the C++ and C examples of README.md and docs/guide/embedding.md as printed,
# against the tree installed in PREFIX, and runs them on a simulated video.
set -eu
prefix=$1 folder=$2 compiler=$3 c_compiler=$4
source=$(cd "$(dirname "$0")" && pwd)
root=$source/../..
rm -rf "$folder"
mkdir -p "$folder/app"
cd "$folder"
PKG_CONFIG_PATH=$(dirname "$(find "$prefix" -name holdfast.pc)")
export PKG_CONFIG_PATH
library_folder=$(dirname "$PKG_CONFIG_PATH")

# example PAGE LANGUAGE N: the page's N-th block of that language.
example() {
  awk -v fence="\`\`\`$2" -v n="$3" '$0 == fence { inside = ++i == n; next } /^```$/ { inside = 0 } inside' "$root/$1" |
    grep . || { echo "$1 has no example $3 in $2" >&2 && return 1; }
}

# What the examples read.
"$prefix/bin/holdfast" simulate sequence --model box --frames 12 --size 640x480 --quiet
cp sequence/model/* .
cp sequence/model/model.obj object.obj
head -n 1 sequence/poses_gt.txt >pose.txt
read -r fx fy cx cy <sequence/K.txt
cat >camera.yml <<YAML
%YAML:1.0
---
image_width: 640
image_height: 480
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ $fx, 0., $cx, 0., $fy, $cy, 0., 0., 1. ]
YAML
opencv=$(pkg-config --cflags opencv4 | sed "s,-I,-isystem ,g")
# shellcheck disable=SC2086  # flags are words
"$compiler" -std=c++20 "$source/make_video.cpp" $opencv -lopencv_videoio -lopencv_imgcodecs -lopencv_core -o make_video
./make_video sequence/frames/%06d.png video.mp4

# A calibration as text has no size.
cp sequence/K.txt camera.txt
example README.md cpp 1 | sed s/camera.yml/camera.txt/ >readme.cpp
example docs/guide/embedding.md cpp 2 | sed s/camera.yml/camera.txt/ >found.cpp
example docs/guide/embedding.md cpp 3 | sed s/camera.yml/camera.txt/ >device.cpp
for name in readme found device; do
  library=holdfast-io
  test $name != found || library="holdfast-detection holdfast-io"
  # shellcheck disable=SC2046,SC2086
  "$compiler" -std=c++20 $name.cpp $opencv $(pkg-config --cflags --libs $library) \
    -lopencv_videoio -lopencv_core -lOpenCL -o $name
done
test "$(./readme | grep -c '^$')" -eq 12
test "$(./found | grep -c '^held')" -eq 12
test "$(./device | grep -c '^held')" -eq 12

example docs/guide/embedding.md cmake 1 >app/CMakeLists.txt
example docs/guide/embedding.md cpp 1 >app/main.cpp
cmake -S app -B build -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_PREFIX_PATH="$prefix"
cmake --build build
build/app >positions
test "$(wc -l <positions)" -eq 11
if grep lost positions; then exit 1; fi

example docs/guide/embedding.md c 1 >example.c
"$c_compiler" -std=c99 -Wall -Wextra -Werror -I"$prefix/include" example.c -L"$library_folder" -lholdfast_c -o example
LD_LIBRARY_PATH=$library_folder ./example | grep '^lost'  # its frame is black
