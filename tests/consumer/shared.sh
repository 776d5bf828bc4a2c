#!/bin/sh
# shared.sh SOURCE BUILD FOLDER CXX: links Holdfast as shared libraries below FOLDER from the objects of the static build
# in BUILD, installs them, compares what they show with what the program takes from them, and runs the consumer.
set -eu
source=$1 build=$2 folder=$3 compiler=$4
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$folder"
cmake -S "$source" -B "$folder/build" -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=ON \
  -DHOLDFAST_BUILD_APPS=OFF -DHOLDFAST_OBJECTS="$build/tests/objects" -DCMAKE_INSTALL_PREFIX="$folder/installed"
cmake --build "$folder/build" --parallel "$(nproc)"
rm -rf "$folder/installed"
cmake --install "$folder/build"

# Every name of namespace holdfast that the program takes from the libraries must be exported.
names() { sed -E 's/^[0-9a-f ]*[A-Za-z] //' | grep '^holdfast::' | sort -u; }
nm -C --undefined-only "$build/apps/libholdfast_app.a" | names >"$folder/taken"
nm -C --defined-only "$build/lib/libholdfast.a" "$build/lib/libholdfast_io.a" "$build/lib/libholdfast_detection.a" 2>/dev/null | names >"$folder/defined"
find "$folder/installed" -name 'libholdfast*.so' -exec nm -DC --defined-only {} + | names >"$folder/shown"
comm -12 "$folder/taken" "$folder/defined" | comm -23 - "$folder/shown" >"$folder/missing"
if [ ! -s "$folder/taken" ] || [ -s "$folder/missing" ]; then
  echo "Not exported (HOLDFAST_EXPORT is missing in the public header), but used by the program:"
  cat "$folder/missing"
  exit 1
fi
# And nothing else of what is linked in or kept to lib/.
if find "$folder/installed" -name 'libholdfast*.so' -exec nm -DC --defined-only {} + | grep -E ' [TB] (cl::|fmt::|YAML::)'; then
  echo "Exported, but no business of a caller"
  exit 1
fi

sh "$here/with_cmake.sh" "$folder/installed" "$folder/with_cmake" "$compiler"
sh "$here/with_pkg_config.sh" "$folder/installed" "$folder/with_pkg_config" "$compiler"
