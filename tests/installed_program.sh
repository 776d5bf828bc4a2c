#!/bin/sh
# installed_program.sh PREFIX PROGRAM_BELOW_PREFIX FOLDER: the installed program starts without what only videos and
# windows need, loads it for a video, and says what is missing where the program alone was copied.
set -eu
program=$1/$2 folder=$3
rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"
fail() {
  echo "FAILED: $1" >&2
  exit 1
}

"$program" devices
! ldd "$program" | grep -E 'opencv_(videoio|highgui)|libav(codec|format)' || fail "the program itself loads libraries for videos"

"$program" simulate in --frames 5 --size 160x120 >/dev/null
head -n 1 in/poses_gt.txt >first.txt
track() { "$@" --model in/model/model.obj --camera in/K.txt --init first.txt --quiet; }
track "$program" track in/frames --poses written.csv --overlay video.avi || fail "no overlay video was written"
# The video shows an overlay: whether the object is held there does not matter.
read_video() { track "$@" || [ $? -eq 6 ]; }
read_video "$program" track video.avi --poses read.csv || fail "the video was not read"
[ "$(wc -l <read.csv)" -eq 6 ] || fail "not every frame of the video was read"

# Moved as a whole it works, alone it does not.
cp -R "$1" moved
read_video "moved/$2" track video.avi --poses moved.csv || fail "the moved program did not read the video"
mkdir alone
cp "$program" alone
track alone/holdfast track in/frames --poses alone.csv || fail "pictures need no module"
code=0
track alone/holdfast track video.avi --poses none.csv 2>message || code=$?
[ "$code" -eq 3 ] || fail "exit code $code where the module is missing"
grep -q 'holdfast_video.so.*install Holdfast again' message || fail "the message is: $(cat message)"
