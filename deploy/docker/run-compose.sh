#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Brings up compose.yaml, renders through it, compares the pictures with those of one process here,
# and takes everything down. It uses a Docker engine where one runs, else podman. Exit 77: skipped,
# with the reason.
# Usage: run-compose.sh [--check | --compile]
#   --check     only reads compose.yaml
#   --compile   compiles inside the image, instead of taking the programs of build/release (or of the
#               build folder that TESSERA_BUILD names)
set -euo pipefail
cd "$(dirname "$0")/../.."
file=deploy/docker/compose.yaml
mode=${1:-}
build=${TESSERA_BUILD:-build/release}

skip() {
  echo "skipped: $1"
  exit 77
}
say() { echo "compose: $1"; }

command -v docker-compose >/dev/null || skip "docker-compose is not installed (deploy/install-dependencies.sh --with compose)"
docker-compose -f "$file" config -q
if [[ $mode == --check ]]; then
  say "$file is right"
  exit 0
fi

work=$(mktemp -d)
engine=
service_pid=
cleanup() {
  local code=$?
  trap '' INT TERM
  if [[ -n $engine ]]; then
    if ((code != 0)); then docker-compose -f "$file" logs --tail=20 2>/dev/null || true; fi
    docker-compose -f "$file" down -v --remove-orphans >"$work/down.log" 2>&1 || cat "$work/down.log"
  fi
  if [[ -n $service_pid ]]; then
    kill "$service_pid" 2>/dev/null || true
    wait "$service_pid" 2>/dev/null || true
  fi
  rm -rf "$work"
  exit "$code"
}
trap cleanup EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

start_podman() {
  cat >"$work/containers.conf" <<'END'
[containers]
default_ulimits = ["nofile=1024:1024", "nproc=4096:4096"]
[engine]
runtime = "runc"
cgroup_manager = "cgroupfs"
events_logger = "file"
[network]
network_backend = "netavark"
END
  export CONTAINERS_CONF=$work/containers.conf
  podman system service --time=0 "unix://$work/podman.sock" >"$work/podman.log" 2>&1 &
  service_pid=$!
  export DOCKER_HOST=unix://$work/podman.sock DOCKER_BUILDKIT=0
  for _ in $(seq 100); do
    if [[ -S $work/podman.sock ]] && podman version >/dev/null 2>&1; then return 0; fi
    sleep 0.1
  done
  skip "podman does not serve here: $(tail -n 1 "$work/podman.log")"
}

# podman fetches no image: the base image is made from the distribution's own packages, once.
make_base() {
  export TESSERA_BASE=localhost/debian:bookworm-slim
  if podman image exists "$TESSERA_BASE"; then return 0; fi
  say "making the base image with debootstrap"
  debootstrap --variant=minbase bookworm "$work/base" >"$work/debootstrap.log" 2>&1 ||
    skip "debootstrap cannot make a base image here: $(tail -n 1 "$work/debootstrap.log")"
  # Where packages come through a proxy or a mirror, the image's apt must know it, too.
  cp -r /etc/apt/apt.conf.d/. "$work/base/etc/apt/apt.conf.d/"
  tar -C "$work/base" -c . | podman import - "$TESSERA_BASE" >/dev/null
}

if docker info >/dev/null 2>&1; then
  engine=docker
elif command -v podman >/dev/null && command -v debootstrap >/dev/null && [[ $(id -u) == 0 ]]; then
  start_podman
  make_base
  engine=podman
else
  skip "no Docker engine runs, and podman with debootstrap and root is not there"
fi
say "on $engine"

if [[ $mode == --compile ]]; then
  export TESSERA_PROGRAMS=compiled
else
  export TESSERA_PROGRAMS=prebuilt
  rm -rf out/docker/programs
  DESTDIR=$PWD/out/docker/programs cmake --install "$build" --prefix /usr/local >/dev/null
fi
# Any port that is likely to be free; the pictures are rendered inside, so nobody connects to it.
TESSERA_PORT=$((20000 + RANDOM % 12000))
# On a busy machine podman may take longer than a minute for a step; ctest ends what hangs.
export COMPOSE_HTTP_TIMEOUT=1800
export TESSERA_PORT COMPOSE_PROJECT_NAME=tessera-test

docker-compose -f "$file" build
docker-compose -f "$file" up -d
app_container=$(docker-compose -f "$file" run -d app sleep infinity)
inside() { "$engine" exec "$app_container" "$@"; }
app=(--connect master:7400 --keys /keys)
slaves() { inside tessera-master status --json "${app[@]}" 2>/dev/null | grep -o '"tile_port"' | wc -l || true; }
for ((i = 0; ; ++i)); do
  count=$(slaves)
  if ((count == 3)); then break; fi
  if ((i == 120)); then
    say "only $count of 3 slaves reached the master" >&2
    exit 1
  fi
  sleep 0.5
done
say "three slaves are there"

# Says what a container may do that it must not, or nothing. $1: its service, $2: its number.
# shellcheck disable=SC2016  # expanded in the container
faults_of() {
  "$engine" exec "$2" bash -c '
    [[ $(grep CapBnd /proc/self/status) == *0000000000000000 ]] || echo "$1 may have capabilities"
    [[ $(grep NoNewPrivs /proc/self/status) == *1 ]] || echo "$1 may gain privileges"
    ! touch /usr/local/bin/x 2>/dev/null || echo "$1 writes to its root"
    [[ $(cd / && echo nodes/*/* authority/*) == "nodes/*/* authority/*" ]] || echo "$1 sees keys of others"
    [[ $(echo /keys/*) == "/keys/ca.crt /keys/node.crt /keys/node.key /keys/ready" ]] || echo "$1 has other keys: $(echo /keys/*)"
    ' bash "$1"
}
keys=()
for service in master slave-1 slave-2 slave-3 app; do
  container=$app_container
  if [[ $service != app ]]; then container=$(docker-compose -f "$file" ps -q "$service"); fi
  faults=$(faults_of "$service" "$container")
  if [[ -n $faults ]]; then
    say "$faults" >&2
    exit 1
  fi
  keys+=("$("$engine" exec "$container" sha256sum /keys/node.key)")
done
if (($(printf '%s\n' "${keys[@]}" | sort -u | wc -l) != 5)); then
  say "containers share a key" >&2
  exit 1
fi
say "each container has its own keys, a root that it cannot write, and no capabilities"

picture=(builtin:cornell --size 320x240 --frames 0:1 --quiet)
digests() { grep -o '"digest": *"[0-9a-f]*"' | tr -d ' '; }
inside tessera-master render "${picture[@]}" "${app[@]}" -o /tmp/x-%04d.pfm --stats /tmp/stats.jsonl
through=$(inside cat /tmp/stats.jsonl | digests)
"$build/bin/tessera-master" render "${picture[@]}" -o "$work/x-%04d.pfm" --stats "$work/stats.jsonl"
here=$(digests <"$work/stats.jsonl")
echo "$through"
if [[ -z $here || $through != "$here" ]]; then
  say "the pictures differ; rendered here: $here" >&2
  exit 1
fi
say "three slaves in containers and one process here drew the same pictures"
