#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Shows that a scene pays nothing for what it does not need: a kernel compiled alone takes as many
# instructions as the same kernel in the table that holds all of them.
#
# Usage: feature_cost.sh FOLDER, where the programs are. Exit code: 0 no more than 0.1 %; 1 more; 77
# valgrind or AVX2 is missing.
set -euo pipefail
folder=$1
command -v valgrind >/dev/null || { echo "skipped: valgrind is not installed"; exit 77; }
"$folder/feature_one_any" 0 >/dev/null || exit  # it ends with 77 without AVX2
# The installed libhwy reads a clock at start that valgrind does not know on every processor.
export LD_LIBRARY_PATH=$folder/../libhwy_stub

# Counts the instructions of PROGRAM for so many FANS within the call of the kernel. Building the scene
# is left out, for it varies by more than what is looked for.
instructions() { # PROGRAM FANS
  valgrind --tool=callgrind --toggle-collect='tessera::core::trace_once*' \
    --callgrind-out-file=/dev/null "$1" "$2" 2>&1 >/dev/null | sed -n 's/.*Collected *: *//p'
}

status=0
printf '%-28s %16s %16s %10s\n' 'instructions per fan' 'among all' 'alone' 'more, %'
for feature in closest any kd; do
  fans=4000
  all=$(instructions "$folder/feature_all_$feature" $fans)
  one=$(instructions "$folder/feature_one_$feature" $fans)
  awk -v name="$feature" -v all="$all" -v one="$one" -v fans="$fans" 'BEGIN {
    more = 100 * (all - one) / one
    printf "%-28s %16.1f %16.1f %10.3f\n", name, all / fans, one / fans, more
    exit one <= 0 || more > 0.1
  }' || status=1
done
exit $status
