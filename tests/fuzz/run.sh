#!/bin/sh
# run.sh BUILD_FOLDER SECONDS [TARGET...]: builds the fuzz targets with clang and runs each for so long, from seeds/ and
# what earlier runs found. Fails where an input crashes, takes over 5 s, or more than 1 GB.
set -eu
build=$1
seconds=$2
shift 2
mkdir -p "$build"
build=$(CDPATH='' cd -- "$build" && pwd)
here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
sanitizers=-fsanitize=fuzzer-no-link,address,undefined
cmake -S "$here/../.." -B "$build" -DCMAKE_BUILD_TYPE=Release -DHOLDFAST_BUILD_TESTS=OFF -DHOLDFAST_BUILD_FUZZERS=ON \
  -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_CXX_FLAGS="-O1 -g $sanitizers -fno-sanitize-recover=undefined"
[ $# -gt 0 ] || set -- ply obj off gltf glb stl camera pose image points
for target in "$@"; do
  cmake --build "$build" --parallel "${JOBS:-$(nproc)}" --target "fuzz_$target"
done
export ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1
failed=""
for target in "$@"; do
  mkdir -p "$build/corpus/$target"
  log=$build/fuzz_$target.log
  (cd "$build" && tests/fuzz/fuzz_"$target" "corpus/$target" "$here/seeds/$target" -max_total_time="$seconds" \
    -timeout=5 -rss_limit_mb=1024 -max_len=8192 -print_final_stats=1 -artifact_prefix="$target-") >"$log" 2>&1 ||
    failed="$failed $target"
  echo "$target: $(sed -n 's/^stat::number_of_executed_units: *//p' "$log") inputs," \
    "$(sed -n 's/^stat::peak_rss_mb: *//p' "$log") MB"
done
[ -z "$failed" ] || { echo "failed:$failed (see $build/fuzz_*.log)" >&2; exit 1; }
