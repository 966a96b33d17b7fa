#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Runs in each container of the compose file and does one of keys, master or slave. /keys holds the
# keys of this container's node alone; the service `keys` sees /authority, which can make new nodes,
# and under /nodes the volume that each node has as its /keys.
# Usage: tessera-entrypoint keys NAME... | master [OPTION...] | slave [OPTION...] | COMMAND...
set -euo pipefail
port=7400

wait_for_keys() {
  for _ in $(seq 600); do
    if [[ -f /keys/ready ]]; then return 0; fi
    sleep 0.1
  done
  echo "no keys after 60 s: did the service 'keys' run, and does it know this node?" >&2
  exit 1
}

hand_out() {  # the keys of the node of this name; its role is the name up to a hyphen
  if [[ -f /nodes/$1/ready ]]; then return 0; fi
  if [[ ! -d /authority/$1 ]]; then tessera-keys add /authority "${1%%-*}" "$1"; fi
  cp -p /authority/"$1"/* "/nodes/$1/"
  touch "/nodes/$1/ready"
}

case ${1:-} in
  keys)
    if [[ ! -f /authority/ca.key ]]; then tessera-keys init /authority; fi
    for name in "${@:2}"; do hand_out "$name"; done
    ;;
  master)
    wait_for_keys
    exec tessera-master serve --listen "0.0.0.0:$port" --keys /keys "${@:2}"
    ;;
  slave)
    wait_for_keys
    exec tessera-slave --master "${MASTER:-master}:$port" --keys /keys "${@:2}"
    ;;
  *) exec "$@" ;;
esac
