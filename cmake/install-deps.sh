#!/bin/sh
# install-deps.sh [GROUP...]: installs the packages of these groups of packages.txt (all groups without arguments) that
# are missing. Touches neither network nor sudo when none is.
set -eu
list=$(dirname "$0")/packages.txt
packages=$(awk -v groups=" ${*:-build test} " '!/^#/ && NF == 2 && index(groups, " " $1 " ") { print $2 }' "$list")

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
  echo "make deps: this system has no apt; nothing is installed. What is needed, by Debian's names:"
  printf '%s\n' "$packages"
  exit 0
fi

missing=
for package in $packages; do
  if ! dpkg-query -W -f '${db:Status-Status}\n' "$package" 2>/dev/null | grep -qx installed; then
    missing="$missing $package"
  fi
done
if [ -z "$missing" ]; then
  echo "make deps: all packages are installed"
  exit 0
fi

as_root=
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null; then
    echo "make deps: packages are missing, and there is no sudo; run as root: apt-get install$missing" >&2
    exit 1
  fi
  as_root=sudo
fi
apt() {
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=300 -o Dpkg::Use-Pty=0 "$@" </dev/null
}
install_missing() {
  # shellcheck disable=SC2086  # one word a package
  apt install -y --no-install-recommends $missing
}

echo "make deps: installing$missing"
log=$(mktemp)
trap 'rm -f "$log"' EXIT
# Package lists may be missing or old: then they are fetched, and it is tried once more.
if ! install_missing >"$log" 2>&1; then
  if ! { apt update && install_missing; } >"$log" 2>&1; then
    tail -n 20 "$log" >&2
    echo "make deps: apt-get could not install$missing (its last words are above); is there a network?" >&2
    exit 1
  fi
fi
echo "make deps: done"
