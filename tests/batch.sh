#!/bin/sh
# batch.sh SOURCE PROGRAM FOLDER: holdfast-batch on three small recordings: all are tracked, finished ones are skipped,
# partial ones are done anew, and a recording that fails harms no other.
set -eu
batch=$1/apps/batch/holdfast-batch program=$2 folder=$3
rm -rf "$folder"
mkdir -p "$folder"
cd "$folder"
HOLDFAST=$program
export HOLDFAST
fail() {
  echo "FAILED: $1" >&2
  exit 1
}

tab=$(printf '\t')
echo "# name${tab}input${tab}model${tab}camera${tab}init" >list
for name in one "two words" three; do
  "$program" simulate "$name.in" --frames 5 --size 160x120 >/dev/null
  head -n 1 "$name.in/poses_gt.txt" >"$name.in/first.txt"
  printf '%s\t%s\t%s\t%s\t%s\n' "$name" "$name.in/frames" "$name.in/model/model.obj" "$name.in/K.txt" \
    "$name.in/first.txt" >>list
done

"$batch" list results --jobs 2 >log 2>&1 || fail "the first run: $(cat log)"
for name in one "two words" three; do
  [ "$(wc -l <"results/$name/poses.csv")" -eq 6 ] || fail "$name has not all its poses"
  grep -q '"summary"' "results/$name/run.json" || fail "$name is not complete"
done

# Nothing is done again, but what is missing, and options reach `track`.
touch -d 2001-01-01 "results/one/poses.csv" "results/two words/poses.csv"
rm -r results/three
mkdir "results/.three.$(hostname).999999999"
"$batch" list results --jobs 2 --stop 3 >log 2>&1 || fail "the second run: $(cat log)"
[ "$(find results -name poses.csv -newermt 2002-01-01 | wc -l)" -eq 1 ] || fail "not exactly one was done again"
[ "$(wc -l <results/three/poses.csv)" -eq 4 ] || fail "--stop did not reach track"
[ -z "$(find results -mindepth 1 -maxdepth 1 -name '.*')" ] || fail "leftovers of a killed run remain"

# A run that is interrupted on its way is not finished.
rm -r results/one
cat >interrupted <<EOF
#!/bin/sh
"$program" "\$@" --stop 2
exit 130
EOF
chmod +x interrupted
if HOLDFAST=./interrupted "$batch" list results >log 2>&1; then fail "an interrupted recording went unnoticed"; fi
grep -q 'one: failed with exit code 130' log || fail "the interrupted one is not named: $(cat log)"
[ ! -e results/one ] || fail "an interrupted recording looks finished"
"$batch" list results >log 2>&1 || fail "after the interruption: $(cat log)"
[ "$(wc -l <results/one/poses.csv)" -eq 6 ] || fail "the interrupted recording was not done anew"

# A recording that is missing; a line of a job array.
rm -r results
printf '%s\t%s\t%s\t%s\t%s\n' missing nowhere.mp4 one.in/model/model.obj one.in/K.txt one.in/first.txt >>list
if "$batch" list results >log 2>&1; then fail "a missing recording went unnoticed"; fi
grep -q 'missing: failed with exit code 3' log || fail "the missing recording is not named: $(cat log)"
[ "$(find results -name poses.csv | wc -l)" -eq 3 ] || fail "the others were not tracked"
rm -r results
"$batch" list results --line 1 >log 2>&1 || fail "--line of a comment: $(cat log)"
"$batch" list results --line 3 >log 2>&1 || fail "--line: $(cat log)"
[ "$(find results -name poses.csv)" = "results/two words/poses.csv" ] || fail "--line 3 did another"

# What cannot be meant is refused in one line.
refused() {
  words=$1 && shift
  status=0
  "$batch" "$@" >log 2>&1 || status=$?
  [ "$status" -eq 2 ] && [ "$(wc -l <log)" -eq 1 ] && grep -q -e "$words" log || fail "$* is not refused: $(cat log)"
}
refused "has no line 99, only 1 to 5" list results --line 99
refused "has no line 0" list results --line 0
refused "a whole number" list results --line two
refused "beside --line" list results --line 3 --jobs 2
refused "'nothing' cannot be read" nothing results

# One thread each, in the calling thread where PoCL can; a driver that the caller names is kept.
cat >wrapped <<EOF
#!/bin/sh
[ "\$1" = devices ] || echo "\$POCL_DEVICES \$POCL_MAX_PTHREAD_COUNT \$LP_NUM_THREADS" >>environment
exec "$program" "\$@"
EOF
chmod +x wrapped
expected=
if POCL_DEVICES=basic "$program" devices >/dev/null 2>&1; then expected=basic; fi
rm -r results
HOLDFAST=./wrapped "$batch" list results --line 2 >log 2>&1 || fail "in one thread: $(cat log)"
[ -z "$expected" ] || [ "$(cat environment)" = "$expected 1 0" ] || fail "threads: $(cat environment)"
rm -r results environment
POCL_DEVICES=pthread HOLDFAST=./wrapped "$batch" list results --line 2 >log 2>&1 || fail "the caller's driver: $(cat log)"
[ "$(cat environment)" = "pthread 1 0" ] || fail "the caller's driver: $(cat environment)"
echo "batch: fine"
