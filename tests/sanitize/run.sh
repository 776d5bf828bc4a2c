#!/bin/sh
# run.sh BUILD_FOLDER [CTEST FLAGS]: builds the tests with AddressSanitizer and UndefinedBehaviorSanitizer and runs those
# that need no second OpenCL.
set -eu
build=$1
shift
here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
jobs=${JOBS:-$(nproc)}
sanitizers="-fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer"
cmake -S "$here/../.." -B "$build" -DCMAKE_BUILD_TYPE=Release -DHOLDFAST_SECOND_OPENCL=OFF \
  -DCMAKE_CXX_FLAGS_RELEASE="-O1 -g -DNDEBUG" -DCMAKE_CXX_FLAGS="$sanitizers" -DCMAKE_C_FLAGS="$sanitizers"
cmake --build "$build" --parallel "$jobs"
# Allocations that fail must fail as without sanitizers: by an exception.
export ASAN_OPTIONS=allocator_may_return_null=1:detect_odr_violation=0
export LSAN_OPTIONS=suppressions=$here/leaks.txt:print_suppressions=0
# PoCL alone, where it can be had alone: Mesa's Rusticl loses 200 bytes as it is asked for devices, most of them from a
# library that is unloaded when they are looked for, and so has no name for leaks.txt.
icd=/etc/OpenCL/vendors/pocl.icd
[ ! -e "$icd" ] || export OCL_ICD_VENDORS="$icd"
cd "$build"
# AddressSanitizer's dlopen does not look where the program says that its modules are.
export LD_LIBRARY_PATH="$PWD/apps${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
ctest --output-on-failure --no-tests=error --parallel "$jobs" --exclude-regex '^(install|consumer|public_headers|batch)' "$@"
