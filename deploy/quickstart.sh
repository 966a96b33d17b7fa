#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# This one command leads from a bare Debian 12 to a picture that two slave daemons rendered for a
# master. It ends exactly the processes that it started, also on Ctrl-C.
set -euo pipefail

usage() {
  cat <<'END'
Usage: deploy/quickstart.sh [SCENE]

Installs what is missing, builds, makes keys, starts one master and two slaves on this machine
(TLS over loopback), renders SCENE (a file, or builtin:NAME; default builtin:evening, a room lit by a
lantern that moves) through them with global illumination, and shows it in a window where there is a display. Pictures and logs go to out/quickstart.
END
}

case ${1:-} in
  -h | --help) usage && exit 0 ;;
  -*) echo "quickstart.sh: unknown option '$1' (see --help)" >&2 && exit 2 ;;
esac
if (($# > 1)); then
  echo "quickstart.sh: one SCENE at most (see --help)" >&2
  exit 2
fi
scene=${1:-builtin:evening}
if [[ $scene != builtin:* ]]; then
  if [[ ! -f $scene || ! -r $scene ]]; then
    echo "quickstart.sh: cannot read the scene file '$scene'" >&2
    exit 1
  fi
  scene=$(realpath -- "$scene")
fi
cd "$(dirname "$0")/.."
out=out/quickstart
bin=build/release/bin
keys=$out/keys
mkdir -p "$out"

exec 9>"$out/lock"
if ! flock -n 9; then
  echo "quickstart.sh: another quickstart runs in this folder; wait for it, or end it" >&2
  exit 1
fi

pids=()
names=()
cleanup() {
  local code=$? i
  trap '' INT TERM HUP  # a second Ctrl-C must not leave anything behind
  for ((i = ${#pids[@]} - 1; i >= 0; --i)); do kill -TERM "${pids[i]}" 2>/dev/null || true; done
  local deadline=$((SECONDS + 5))
  for i in "${!pids[@]}"; do
    while kill -0 "${pids[i]}" 2>/dev/null && ((SECONDS < deadline)); do sleep 0.05; done
    if kill -KILL "${pids[i]}" 2>/dev/null; then
      echo "quickstart.sh: ${names[i]} did not end when asked and was killed" >&2
    fi
    wait "${pids[i]}" 2>/dev/null || true
  done
  exit "$code"
}
trap cleanup EXIT
trap 'exit 130' INT
trap 'exit 143' TERM HUP

forget() {  # drops a process that was waited for, since its number may soon be another's
  local i
  for i in "${!pids[@]}"; do
    if [[ ${pids[i]} == "$1" ]]; then
      unset "pids[i]" "names[i]"
      pids=("${pids[@]}")
      names=("${names[@]}")
      return
    fi
  done
}

start() {  # runs a command in the background, with its output in the log of a name (the first argument)
  "${@:2}" >"$out/$1.log" 2>&1 9>&- &
  pids+=($!)
  names+=("$1")
}

# Runs a program as this shell's own job, so that Ctrl-C is answered at once.
attend() {
  local code=0 pid
  "$@" 9>&- &
  pid=$!
  pids+=("$pid")
  names+=("${1##*/}")
  wait "$pid" || code=$?
  forget "$pid"
  return "$code"
}

# Ctrl-C reaches every process of this group. Bash may lose its own signal where it has just waited
# for a program, and then sees a master that is gone; only Ctrl-C makes one that runs take its leave.
leave_if_interrupted() {
  if ((${#pids[@]} == 0)); then return; fi  # no master runs
  local i
  if ! is_taken "$port"; then
    for ((i = 0; i < 50; ++i)); do  # it writes its last line after it has closed its port
      if ! kill -0 "${pids[0]}" 2>/dev/null; then break; fi
      sleep 0.1
    done
  fi
  if grep -qs ' ending: ' "$out/master.log"; then exit 130; fi
}

give_up() {  # prints a message and the last lines of a log, and exits
  leave_if_interrupted
  echo "quickstart.sh: $1" >&2
  if [[ -n ${2:-} && -s $2 ]]; then tail -n 5 "$2" | sed "s|^|  ${2##*/}: |" >&2; fi
  exit 1
}

deploy/install-dependencies.sh --with build
echo "building (the first time takes minutes)"
if ! deploy/build.sh programs 9>&-; then give_up "the build failed; its messages are above"; fi

rm -rf "$keys"
{
  "$bin/tessera-keys" init "$keys"
  for member in "master master" "slave slave-1" "slave slave-2" "app app"; do
    read -r role name <<<"$member"
    "$bin/tessera-keys" add "$keys" "$role" "$name"
  done
} >"$out/keys.log" 2>&1 || give_up "cannot make keys" "$out/keys.log"

is_taken() { (exec 3<>"/dev/tcp/127.0.0.1/$1") 2>/dev/null; }
status() {
  "$bin/tessera-master" status --json --connect "127.0.0.1:$port" --keys "$keys/app" \
    >"$out/status.json" 2>/dev/null
}

# A port that is free now may be taken a moment later, so the master tries several.
start_master() {
  local i
  for _ in 1 2 3 4 5; do
    port=$((20000 + RANDOM % 12000))
    if is_taken "$port"; then continue; fi
    start master "$bin/tessera-master" serve --listen "127.0.0.1:$port" --keys "$keys/master"
    for ((i = 0; i < 100; ++i)); do
      if status; then return 0; fi
      if ! kill -0 "${pids[-1]}" 2>/dev/null; then break; fi
      sleep 0.1
    done
    leave_if_interrupted
    kill "${pids[-1]}" 2>/dev/null || true
    wait "${pids[-1]}" 2>/dev/null || true
    forget "${pids[-1]}"
  done
  give_up "the master does not start" "$out/master.log"
}

start_master
threads=$((($(nproc) + 1) / 2))
for name in slave-1 slave-2; do
  start "$name" "$bin/tessera-slave" --master "127.0.0.1:$port" --keys "$keys/$name" \
    --name "$name" --threads "$threads"
done
echo "master on 127.0.0.1:$port, slaves slave-1 and slave-2 with $threads threads each"

for ((i = 0; ; ++i)); do
  status || true
  if grep -qz '"tile_port".*"tile_port"' "$out/status.json"; then break; fi
  for j in "${!pids[@]}"; do
    if ! kill -0 "${pids[j]}" 2>/dev/null; then give_up "${names[j]} ended" "$out/${names[j]}.log"; fi
  done
  if ((i == 200)); then give_up "the slaves do not reach the master" "$out/slave-1.log"; fi
  sleep 0.1
done

app=(--connect "127.0.0.1:$port" --keys "$keys/app")
case $scene in
  builtin:waves) path=() ;;  # the scene moves by itself
  builtin:evening | builtin:room)
    cat >"$out/room.camera" <<'END'
up 0 1 0
vfov 58
frame 0
eye 2.1 1.65 2.2
target -0.35 0.95 -0.6
frame 11
eye -1.9 1.5 2.2
target 0.5 0.9 -0.9
END
    path=(--camera "$out/room.camera")
    ;;
  *) path=(--orbit 55) ;;
esac
# Each frame is a second of time, so that the lantern goes round once.
light=(--renderer igi --fps 1)
rm -f "$out"/frame-*.png "$out/frame.exr"
attend "$bin/tessera-master" render "$scene" "${app[@]}" "${path[@]}" "${light[@]}" --frames 0:11 --size 640x480 --stats "$out/stats.jsonl" \
  -o "$out/frame-%04d.png" || give_up "rendering failed" "$out/master.log"
attend "$bin/tessera-master" render "$scene" "${app[@]}" "${light[@]}" --frames 0:0 --size 640x480 -o "$out/frame.exr" ||
  give_up "rendering failed" "$out/master.log"

echo
echo "pictures: $out/frame-0000.png to frame-0011.png"
echo "          $out/frame.exr (linear radiance)"
echo "logs:     $out/master.log, slave-1.log, slave-2.log; per frame: stats.jsonl"

if [[ -n ${DISPLAY:-}${WAYLAND_DISPLAY:-} ]]; then
  echo "opening the window; close it to end the cluster"
  attend "$bin/tessera-master" view "$scene" "${app[@]}" --renderer igi || give_up "the window did not open; the pictures are there"
fi
