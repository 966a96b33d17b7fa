#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Shows what a scene pays for features that it does not have. It counts the core's instructions, on one
# thread, for a frame of plain diffuse triangles, in a usual build, in one whose code for textures,
# normal maps, programs, glossy and specular surfaces and the sky is compiled away, and in one that
# knows neither patches nor trims.
#
# Usage: core_cost.sh [BUILD_FOLDER]   (default build/plain-core; it configures and builds there)
# Exit code: 0 no more than 0.1 %; 1 more; 77 valgrind is missing.
set -euo pipefail
cd "$(dirname "$0")/../../.."
folder=${1:-build/plain-core}
command -v valgrind >/dev/null || { echo "skipped: valgrind is not installed"; exit 77; }
# Where code is compiled away, the compiler sees what was never set on ways that no scene takes.
declare -A flags=(
  [usual]=""
  [plain]="-DTESSERA_PLAIN_CORE -Wno-maybe-uninitialized"
  [triangles]=-DTESSERA_WITHOUT_PATCHES
)
for kind in usual plain triangles; do
  cmake -S . -B "$folder/$kind" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS_RELEASE="-O2 -DNDEBUG" \
    -DCMAKE_CXX_FLAGS="${flags[$kind]}" >/dev/null
  log=$folder/$kind/build.log
  ninja -C "$folder/$kind" frame_once libhwy_stub >"$log" || {
    grep -E 'error|FAILED' "$log" >&2
    exit 1
  }
done
# The installed libhwy reads a clock at start that valgrind does not know on every processor.
LD_LIBRARY_PATH=$(realpath "$folder")/usual/libhwy_stub
export LD_LIBRARY_PATH

instructions() { # counts those of the build KIND with RENDERER
  valgrind --tool=callgrind --toggle-collect='tessera::core::render_once*' --callgrind-out-file=/dev/null \
    "$folder/$1/bin/frame_once" "$2" 2>&1 >/dev/null | sed -n 's/.*Collected *: *//p'
}

status=0
printf '%-8s %-20s %16s %16s %10s\n' 'renderer' 'compiled away' 'as ever' 'without' 'more, %'
compare() { # prints the row NAME: the usual build and the build KIND with RENDERER
  local usual without
  usual=$(instructions usual "$2")
  without=$(instructions "$1" "$2")
  awk -v renderer="$2" -v name="$3" -v usual="$usual" -v without="$without" 'BEGIN {
    more = 100 * (usual - without) / without
    printf "%-8s %-20s %16.0f %16.0f %10.3f\n", renderer, name, usual, without, more
    exit without <= 0 || more > 0.1
  }' || status=1
}
compare plain direct "features, sky"
compare plain igi "features, sky"
compare plain path "features, sky"
compare triangles primary "patches, trims"
compare triangles direct "patches, trims"
compare triangles igi "patches, trims"
compare triangles path "patches, trims"
if ((status != 0)); then echo "FAILED: more than 0.1 % in a row above"; fi
exit $status
