#!/bin/sh
# make-venv.sh FOLDER GROUP...: makes a Python environment there, or adds to it, with the packages of these groups of
# python-packages.txt. Touches no network when the folder has them.
set -eu
list=$(dirname "$0")/python-packages.txt
folder=$1
shift
wanted=$(awk -v groups=" $* " '!/^#/ && NF == 2 && index(groups, " " $1 " ") { print $2 }' "$list")
missing=
for package in $wanted; do
  grep -qxF "$package" "$folder/packages.txt" 2>/dev/null || missing="$missing $package"
done
if [ -z "$missing" ]; then
  echo "make deps: the Python environment is there"
  exit 0
fi
echo "make deps: adding to the Python environment in $folder:$missing"
test -x "$folder/bin/python" || python3 -m venv "$folder"
# shellcheck disable=SC2086  # one word a package
if ! "$folder/bin/python" -m pip install -q --disable-pip-version-check $missing; then
  echo "make deps: pip could not install$missing (its last words are above); is there a network?" >&2
  exit 1
fi
printf '%s\n' $missing >>"$folder/packages.txt"
