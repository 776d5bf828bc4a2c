#!/bin/sh
# threads.sh BUILD_FOLDER: ThreadSanitizer over the pipeline of `track` and over two trackers on one device.
set -eu
build=$1
here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
cmake -S "$here/../.." -B "$build" -DCMAKE_BUILD_TYPE=Release -DHOLDFAST_SECOND_OPENCL=OFF \
  -DCMAKE_CXX_FLAGS="-O1 -g -fsanitize=thread -fno-omit-frame-pointer"
cmake --build "$build" --parallel "${JOBS:-$(nproc)}" --target test_threads
export TSAN_OPTIONS="suppressions=$here/races.txt halt_on_error=0 exitcode=66"
# Without random addresses, which sanitizers older than the kernel do not understand.
setarch "$(uname -m)" -R "$build/tests/test_threads"
