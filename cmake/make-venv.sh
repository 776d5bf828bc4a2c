#!/bin/sh
# make-venv.sh FOLDER: makes a Python environment with the packages of python-packages.txt there. Touches no network when
# the folder has them.
set -eu
list=$(dirname "$0")/python-packages.txt
folder=$1
if cmp -s "$list" "$folder/packages.txt"; then
  echo "make deps: the Python environment is there"
  exit 0
fi
echo "make deps: making a Python environment in $folder"
python3 -m venv "$folder"
if ! "$folder/bin/python" -m pip install -q --disable-pip-version-check -r "$list"; then
  echo "make deps: pip could not install what $list names (its last words are above); is there a network?" >&2
  exit 1
fi
cp "$list" "$folder/packages.txt"
