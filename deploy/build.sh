#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Configures where needed and builds one preset; a second call does nothing but ask ninja.
# Usage: deploy/build.sh [--preset NAME] [--tests] [TARGET...]
set -euo pipefail
cd "$(dirname "$0")/.."

preset=release
with_tests=OFF
while (($# > 0)); do
  case $1 in
    --preset) preset=${2:?"build.sh: --preset needs a name"} && shift 2 ;;
    --tests) with_tests=ON && shift ;;
    -h | --help) sed -n '3,4s/^# //p' "$0" && exit 0 ;;
    -*) echo "build.sh: unknown option '$1'" >&2 && exit 2 ;;
    *) break ;;
  esac
done
folder=build/$preset
# One compiler cache serves every clone on this machine.
export CCACHE_NOHASHDIR=1 CCACHE_BASEDIR=$PWD

cached() {  # prints a variable of the CMake cache, or nothing where it has none
  sed -n "s/^$1:[A-Z]*=//p" "$folder/CMakeCache.txt" 2>/dev/null || true
}
options=()
is_current=no
if [[ -f $folder/build.ninja ]]; then
  if [[ $(cached CMAKE_HOME_DIRECTORY) != "$PWD" ]]; then
    options=(--fresh)  # a folder that was moved or copied holds another tree's paths
  elif [[ $with_tests == OFF || $(cached TESSERA_TESTS) == ON ]]; then
    is_current=yes  # ninja itself configures anew when a CMakeLists.txt has changed
  fi
fi
if [[ $is_current == no ]]; then
  # The preset clang-annotations turns the tests off itself.
  if [[ $preset != clang-annotations ]]; then options+=("-DTESSERA_TESTS=$with_tests"); fi
  cmake --preset "$preset" "${options[@]}"
fi

jobs=$(nproc)
# A compiler process takes up to 1.5 GB here, so fewer run at a time where memory is short.
memory_gib=$(awk '/^MemAvailable/ {print int($2 / 1048576)}' /proc/meminfo 2>/dev/null || echo 8)
memory_jobs=$((memory_gib * 2 / 3))
if ((memory_jobs < 1)); then memory_jobs=1; fi
if ((memory_jobs < jobs)); then jobs=$memory_jobs; fi
exec ninja -C "$folder" -j "$jobs" "$@"
