#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs the fault matrix with real processes: tests/faults.sh [--all | --small | ROW ...] [--json FILE] [--list]
#
# TESSERA_BIN names the folder of the programs (default: the release build). It needs root and network
# namespaces; exit code 77 where this machine has none. tests/faults/README.md has the rows.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
export TESSERA_BIN=${TESSERA_BIN:-$here/../build/release/bin} PYTHONDONTWRITEBYTECODE=1
if [ ! -x "$TESSERA_BIN/tessera-master" ]; then
  echo "faults.sh: no tessera-master in $TESSERA_BIN; build first (deploy/build.sh) or set TESSERA_BIN" >&2
  exit 1
fi
exec python3 "$here/faults/main.py" "$@"
