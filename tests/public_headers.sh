#!/bin/sh
# public_headers.sh INCLUDE CXX EIGEN: every public header compiles alone, without warnings, and includes, however far
# down, no header of OpenCL, OpenGL, OpenCV or assimp.
set -eu
include=$1 compiler=$2 eigen=$3
status=0
count=0
for header in "$include"/holdfast/*.hpp; do
  name=holdfast/$(basename "$header")
  used=$(printf '#include "%s"\n' "$name" |
    "$compiler" -std=c++20 -Wall -Wextra -Wpedantic -Werror -I"$include" -isystem "$eigen" -fsyntax-only \
      -MD -MF /dev/stdout -x c++ -)
  if printf '%s\n' "$used" | tr ' ' '\n' | grep -E '/(CL|GL|EGL|KHR|opencv4|opencv2|assimp)/'; then
    echo "$name includes the above"
    status=1
  fi
  count=$((count + 1))
done
echo "$count public headers"
if [ "$count" -lt 10 ]; then
  echo "there should be more"
  status=1
fi
exit "$status"
