#!/bin/sh
# run_demo.sh PROGRAM FOLDER: tracks the hand-held cardboard box of OpenCV's tutorial video, from nothing but the box's
# size and six of its corners marked in the first frame. All results go to FOLDER. The video comes out of Debian's
# package opencv-doc (it is kept in FOLDER); without it a sequence that Holdfast renders itself is tracked instead.
# Shows a window where there is a display (q goes on without it). Ends with a start without a pose.
# At the end the box is found without a first pose, in a window where there is a display.
# Fails when the box is lost in any frame, or is not where its corners were marked by hand.
set -eu
program=$1
folder=$2
here=$(dirname "$0")
mkdir -p "$folder"
failed=0
video=$folder/box.mp4

# Finds the object of a recording without a first pose and follows it, in a window where there is a display.
find_it() (
  set -- "$@" --require-held
  if [ -n "${DISPLAY:-}${WAYLAND_DISPLAY:-}" ]; then
    "$program" track "$@" --show && return
    echo "Without a window:"
  fi
  "$program" track "$@"
)

# Fetches and unpacks in a folder of its own, so that neither the package nor half a video stays behind. Says why not.
fetch_video() (
  temporary=$(mktemp -d "$(cd "$folder" && pwd)/fetch.XXXXXX")
  trap 'rm -rf "$temporary"' EXIT
  log=$temporary/log
  for tool in apt-get dpkg-deb gunzip; do
    command -v "$tool" >/dev/null || { echo "there is no $tool to get Debian's package opencv-doc with"; return 1; }
  done
  cd "$temporary"
  # The system's package lists, or (old, or none) lists of our own, which need no root.
  own="-o Dir::State::lists=$PWD/lists -o Dir::Cache=$PWD/cache"
  mkdir -p lists/partial cache/archives/partial
  # shellcheck disable=SC2086  # options are words
  if ! apt-get -q download opencv-doc >"$log" 2>&1 </dev/null &&
    ! { apt-get -q $own update && apt-get -q $own download opencv-doc; } >"$log" 2>&1 </dev/null; then
    echo "Debian's package opencv-doc cannot be downloaded: $(grep -E 'Failed to fetch|^E:' "$log" | head -n 1)"
    return 1
  fi
  path=./usr/share/doc/opencv-doc/opencv4/html/box.mp4.gz
  if ! dpkg-deb --fsys-tarfile opencv-doc_*.deb | tar -x "$path" || ! gunzip -c "$path" >box.mp4; then
    echo "Debian's package opencv-doc holds no box.mp4.gz"
    return 1
  fi
  mv box.mp4 ../box.mp4
)

track_box() {
  echo
  echo "== 1 of 4: the first pose and the focal length, from six corners of the box in frame 0"
  "$program" init --points "$here/box_corners_frame0.csv" --model "$here/box.obj" --image "$video" --frame 0 \
    --estimate-focal --pose "$folder/pose.txt" --camera-out "$folder/camera.yml" --picture "$folder/first_pose.png"
  echo
  echo "== 2 of 4: the box's texture, from the video as the box turns"
  "$program" bake "$video" --model "$here/box.obj" --camera "$folder/camera.yml" --init "$folder/pose.txt" \
    --keep-pose --out "$folder/box_textured.obj"  # the real box is higher than its model
  echo
  echo "== 3 of 4: the box through the whole video"
  "$program" track "$video" --model "$folder/box_textured.obj" --camera "$folder/camera.yml" \
    --init "$folder/pose.txt" --poses "$folder/poses.csv" --overlay "$folder/overlay.mp4" \
    --contact-sheet "$folder/contact_sheet.png" --require-held || failed=$?
  echo
  echo "== Check: corners marked by hand in 15 frames, and where these poses put them"
  "$program" evaluate --marks "$here/../../tests/data/box_real_corners.csv" --poses "$folder/poses.csv" \
    --camera "$folder/camera.yml" --within 4,10 || failed=$?
  echo
  echo "== 4 of 4: the box found without a first pose, in the middle of the video"
  find_it "$video" --model "$folder/box_textured.obj" --camera "$folder/camera.yml" --start 200 || failed=$?
}

track_rendered() {
  sequence=$folder/rendered
  echo
  echo "== 1 of 3: a box moves behind a white bar, rendered by holdfast simulate"
  "$program" simulate "$sequence" --model box --frames 200 --occluder bar --overwrite
  head -n 1 "$sequence/poses_gt.txt" >"$folder/pose.txt"
  echo
  echo "== 2 of 3: the box through all its frames"
  "$program" track "$sequence/frames" --model "$sequence/model/model.obj" --camera "$sequence/K.txt" \
    --init "$folder/pose.txt" --poses "$folder/poses.csv" --overlay "$folder/overlay.mp4" \
    --contact-sheet "$folder/contact_sheet.png" --require-held || failed=$?
  echo
  echo "== 3 of 3: the box found without a first pose, in the middle of the recording"
  find_it "$sequence/frames" --model "$sequence/model/model.obj" --camera "$sequence/K.txt" --start 100 || failed=$?
}

if [ ! -s "$video" ]; then
  echo "Fetching OpenCV's tutorial video of a hand-held box (95 MB, Debian's package opencv-doc) ..."
fi
if [ -s "$video" ] || reason=$(fetch_video); then
  track_box
else
  echo "DEMO FALLBACK: $reason"
  track_rendered
fi

echo
echo "Poses, a row a frame:        $folder/poses.csv"
echo "The video with what is held: $folder/overlay.mp4"
echo "Some of its frames at once:  $folder/contact_sheet.png"
if [ "$failed" -ne 0 ]; then
  echo "The box was not held as it should be: see above." >&2
fi
exit "$failed"
