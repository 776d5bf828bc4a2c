#!/bin/sh
# install-deps.sh [GROUP...]: installs the packages of these groups of packages.txt (build and test without arguments)
# that are missing, and says what the distribution does not have. Touches neither network nor sudo when none is missing.
set -eu
list=$(dirname "$0")/packages.txt
groups=" ${*:-build test} "

# A line a package: its names, the first the best; what is gone without it, if it may be missing.
wanted=$(awk -v groups="$groups" '!/^#/ && NF >= 2 && index(groups, " " $1 " ") { $1 = ""; print substr($0, 2) }' \
  "$list")

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
  echo "make deps: this system has no apt; nothing is installed. What is needed, by Debian's names:"
  printf '%s\n' "$wanted" | sed -e 's/ .*//' -e 's/|/ or /g'
  exit 0
fi

is_installed() { dpkg-query -W -f '${db:Status-Status}\n' "$1" 2>/dev/null | grep -qx installed; }
is_available() { apt-cache policy "$1" 2>/dev/null | grep -q '^ *Candidate: [^(]'; }
# Sets missing (to install), lacking (needed, but not to be had) and without (to be done without, in words).
look() {
  missing='' lacking='' without=''
  while read -r names purpose; do
    found=''
    for name in $(printf '%s' "$names" | tr '|' ' '); do
      if is_installed "$name"; then
        found=installed
      elif is_available "$name"; then
        found=$name
        missing="$missing $name"
      fi
      [ -z "$found" ] || break
    done
    [ -z "$found" ] || continue
    if [ -n "$purpose" ]; then
      without="$without$names: $purpose
"
    else
      lacking="$lacking $names"
    fi
  done <<END
$wanted
END
}
has_lists() { ls "${APT_LISTS:-/var/lib/apt/lists}"/*_Packages* >/dev/null 2>&1; }
say_without() { [ -z "$without" ] || printf '%s' "$without" | sed 's/^/make deps: this distribution has no /'; }

look
if [ -z "$missing$lacking" ] && { [ -z "$without" ] || has_lists; }; then
  echo "make deps: all packages are installed${without:+ that this distribution has}"
  say_without
  exit 0
fi

as_root=
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null; then
    echo "make deps: packages are missing, and there is no sudo; run as root: apt-get install$missing$lacking" >&2
    exit 1
  fi
  as_root=sudo
fi
apt() {
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=300 -o Dpkg::Use-Pty=0 "$@" </dev/null
}
install_missing() {
  # shellcheck disable=SC2086  # one word a package
  [ -z "$missing" ] || apt install -y --no-install-recommends $missing
}

log=$(mktemp)
trap 'rm -f "$log"' EXIT
fail() {
  tail -n 20 "$log" >&2
  echo "make deps: $1" >&2
  exit 1
}
[ -z "$missing" ] || echo "make deps: installing$missing"
# Package lists may be missing or old: then they are fetched, and it is tried once more.
if [ -n "$lacking" ] || { [ -n "$without" ] && ! has_lists; } || ! install_missing >"$log" 2>&1; then
  apt update >"$log" 2>&1 || fail "apt-get update fails (its last words are above); is there a network?"
  look
  if [ -n "$lacking" ]; then
    echo "make deps: this distribution has no$lacking, which Holdfast needs" >&2
    exit 1
  fi
  [ -z "$missing" ] || echo "make deps: installing$missing"
  if ! install_missing >"$log" 2>&1; then
    fail "apt-get could not install$missing (its last words are above)"
  fi
fi
say_without
echo "make deps: done"
