#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Runs in each container of the compose file and does one of keys, master or slave. The volume /keys
# holds one folder per node; the service `keys` alone sees /authority, which can make new nodes.
set -euo pipefail
port=7400

wait_for_keys() {
  for _ in $(seq 600); do
    if [[ -f /keys/ready ]]; then return 0; fi
    sleep 0.1
  done
  echo "no keys after 60 s: did the service 'keys' run?" >&2
  exit 1
}

case ${1:-} in
  keys)
    if [[ -f /keys/ready ]]; then exit 0; fi
    tessera-keys init /authority >/dev/null
    tessera-keys add /authority master master >/dev/null
    tessera-keys add /authority app app >/dev/null
    for i in $(seq "${SLAVES_MAX:-16}"); do tessera-keys add /authority slave "slave-$i" >/dev/null; done
    cp -rp /authority/master /authority/app /authority/slave-* /keys/
    touch /keys/ready
    ;;
  master)
    wait_for_keys
    exec tessera-master serve --listen "0.0.0.0:$port" --keys /keys/master "${@:2}"
    ;;
  slave)
    wait_for_keys
    # A certificate is for one slave: each slave takes the first folder that no other one holds, for
    # as long as it lives (the lock passes on to the slave with the open file).
    for folder in /keys/slave-*; do
      exec 9>"$folder/lock"
      if flock -n 9; then
        name=${folder##*/}
        exec tessera-slave --master "${MASTER:-master}:$port" --keys "$folder" --name "$name" "${@:2}"
      fi
    done
    echo "every slave's key is in use; raise SLAVES_MAX and make keys anew" >&2
    exit 1
    ;;
  *) exec "$@" ;;
esac
