#!/bin/sh
# install_deps.sh SOURCE_FOLDER WORK_FOLDER: cmake/install-deps.sh against a made-up distribution: what it installs, what
# it goes without, when it fails, and that it asks the network for nothing when nothing is missing.
set -eu
source=$1
work=$2
rm -rf "$work"
mkdir -p "$work/bin" "$work/cmake" "$work/lists"
cp "$source/cmake/install-deps.sh" "$work/cmake"
cat >"$work/cmake/packages.txt" <<'END'
# comment
build compiler
build first|second
test checker nothing is checked
other unasked
END
# Packages are files: installed/NAME, there/NAME (in the lists), new/NAME (in the lists after an update).
cat >"$work/bin/dpkg-query" <<'END'
#!/bin/sh
for name in "$@"; do :; done
[ -e "installed/$name" ] && echo installed
END
cat >"$work/bin/apt-cache" <<'END'
#!/bin/sh
echo "$2:"
if [ -e "there/$2" ]; then echo "  Candidate: 1.0"; else echo "  Candidate: (none)"; fi
END
cat >"$work/bin/apt-get" <<'END'
#!/bin/sh
echo "$*" >>calls
for word in "$@"; do
  case $word in
    update) touch lists/x_Packages; mv new/* there/ 2>/dev/null; exit 0 ;;
    install) installing=1 ;;
    [a-z]*) [ -z "${installing:-}" ] || { [ -e "there/$word" ] && touch "installed/$word"; } || exit 100 ;;
  esac
done
END
cat >"$work/bin/sudo" <<'END'
#!/bin/sh
exec "$@"
END
chmod +x "$work"/bin/*
cd "$work"
export PATH="$work/bin:$PATH" APT_LISTS="$work/lists"

# begin INSTALLED THERE NEW: the distribution's packages.
begin() {
  rm -rf installed there new lists calls
  mkdir installed there new lists
  : >calls
  for name in $1; do touch "installed/$name"; done
  for name in $2; do touch "there/$name" lists/x_Packages; done
  for name in $3; do touch "new/$name"; done
}
check() { # check EXIT_CODE INSTALLED WORDS...: runs it
  code=0
  sh cmake/install-deps.sh build test >out 2>&1 || code=$?
  now=$(ls installed | tr '\n' ' ')
  [ "$code" = "$1" ] && [ "$now" = "$2" ] || { echo "exit $code, installed: $now; wanted $1, $2" >&2; cat out >&2; exit 1; }
  shift 2
  for words in "$@"; do
    grep -q "$words" out || { echo "'$words' is not said:" >&2; cat out >&2; exit 1; }
  done
}

begin "compiler first checker" "" ""
check 0 "checker compiler first " "all packages are installed"
[ ! -s calls ]

begin "" "compiler first second checker" ""
check 0 "checker compiler first " "done"
! grep -q update calls

# No lists yet.
begin "" "" "compiler second checker"
check 0 "checker compiler second " "done"

# Without the second column's first name and the optional one; the next time it asks nobody.
begin "" "compiler second" ""
check 0 "compiler second " "no checker: nothing is checked" "done"
: >calls
check 0 "compiler second " "no checker: nothing is checked"
[ ! -s calls ]

# A better one that is to be had.
begin "compiler second checker" "first" ""
check 0 "checker compiler first second " "done"

begin "" "compiler checker" ""
check 1 "" "no first|second"
