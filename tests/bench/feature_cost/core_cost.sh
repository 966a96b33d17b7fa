#!/bin/bash
# Shows what a scene pays for features that it does not have: instructions of the core, one thread, for
# a frame of plain diffuse triangles, in a build as ever and in one whose code for textures, normal
# maps, programs, glossy and specular surfaces is compiled away.
#
# Usage: core_cost.sh [BUILD_FOLDER]   (default build/plain-core; it configures and builds there)
# Exit code: 0 no more than 0.1 %; 1 more; 77 valgrind is missing.
set -euo pipefail
cd "$(dirname "$0")/../../.."
folder=${1:-build/plain-core}
command -v valgrind >/dev/null || { echo "skipped: valgrind is not installed"; exit 77; }
for kind in usual plain; do
  flags=
  if [[ $kind == plain ]]; then flags=-DTESSERA_PLAIN_CORE; fi
  cmake -S . -B "$folder/$kind" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS_RELEASE="-O2 -DNDEBUG" \
    -DCMAKE_CXX_FLAGS="$flags" >/dev/null
  ninja -C "$folder/$kind" frame_once >/dev/null
done

instructions() { # KIND RENDERER
  valgrind --tool=callgrind --toggle-collect='tessera::core::render_once*' --callgrind-out-file=/dev/null \
    "$folder/$1/bin/frame_once" "$2" 2>&1 >/dev/null | sed -n 's/.*Collected *: *//p'
}

status=0
printf '%-12s %16s %16s %10s\n' 'instructions' 'as ever' 'plain' 'more, %'
for renderer in direct igi path; do
  usual=$(instructions usual "$renderer")
  plain=$(instructions plain "$renderer")
  awk -v name="$renderer" -v usual="$usual" -v plain="$plain" 'BEGIN {
    more = 100 * (usual - plain) / plain
    printf "%-12s %16.0f %16.0f %10.3f\n", name, usual, plain, more
    exit plain <= 0 || more > 0.1
  }' || status=1
done
exit $status
