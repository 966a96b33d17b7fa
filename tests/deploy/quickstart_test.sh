#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# The quick start on a built tree makes pictures of a scene file and leaves nothing running, however it ends.
# Usage: quickstart_test.sh SOURCE_FOLDER. Exit 77: skipped, with the reason.
set -euo pipefail
cd "$1"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() {
  echo "FAILED: $1"
  tail -n 20 "$work/log"
  exit 1
}
if ! deploy/install-dependencies.sh --with build --list >/dev/null; then
  echo "skipped: not on Debian 12"
  exit 77
fi

# Prints the processes of this tree's quick start, whose keys lie in its folder.
left() { pgrep -f -- "--keys out/quickstart/keys" || true; }
if [[ -n $(left) ]]; then
  echo "skipped: a quick start is running in this tree"
  exit 77
fi

printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n' >"$work/a scene.obj"
env -u DISPLAY -u WAYLAND_DISPLAY deploy/quickstart.sh "$work/a scene.obj" >"$work/log" 2>&1 ||
  fail "it ends with an error"
for picture in out/quickstart/frame-{0000..0011}.png out/quickstart/frame.exr; do
  [[ -s $picture ]] || fail "$picture is not there"
done
[[ -z $(left) ]] || fail "processes are left: $(left)"

for presses in 1 2; do
  : >"$work/log"  # else the lines of the run before may be taken for this one's
  setsid env --default-signal=INT -u DISPLAY -u WAYLAND_DISPLAY deploy/quickstart.sh >"$work/log" 2>&1 &
  pid=$!
  for ((i = 0; i < 600; ++i)); do
    if grep -q "^master on" "$work/log"; then break; fi
    sleep 0.1
  done
  sleep 0.5
  for ((i = 0; i < presses; ++i)); do
    kill -INT -- "-$pid" 2>/dev/null || true  # a terminal signals the whole group, too
    sleep 0.1
  done
  code=0
  wait "$pid" || code=$?
  ((code == 130)) || fail "after $presses Ctrl-C it ends with $code, not 130"
  [[ -z $(left) ]] || fail "after $presses Ctrl-C processes are left: $(left)"
done

# Bash may lose a Ctrl-C that its programs see: the master says goodbye, and what follows cannot connect.
: >"$work/log"
env -u DISPLAY -u WAYLAND_DISPLAY deploy/quickstart.sh >"$work/log" 2>&1 &
pid=$!
for ((i = 0; i < 600; ++i)); do
  if grep -q "^master on" "$work/log"; then break; fi
  sleep 0.1
done
pkill -INT -f -- "tessera-master serve .*--keys out/quickstart/keys/master" || fail "no master runs"
code=0
wait "$pid" || code=$?
((code == 130)) || fail "after a Ctrl-C that only the master saw it ends with $code, not 130"
[[ -z $(left) ]] || fail "after a Ctrl-C that only the master saw processes are left: $(left)"

code=0
deploy/quickstart.sh "$work/gone.obj" >"$work/log" 2>&1 || code=$?
((code == 1)) || fail "a scene that is not there ends it with $code"
grep -q "gone.obj" "$work/log" || fail "the missing scene is not named"
echo "pictures, and nothing left behind"
