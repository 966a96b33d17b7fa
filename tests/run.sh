#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Installs what is missing, builds, runs the tests, and says what was skipped. Exit code 0: all passed.
set -euo pipefail
cd "$(dirname "$0")/.."

usage() {
  cat <<'END'
Usage: tests/run.sh [--quick | --sanitizers] [--require LABEL,...] [--preset NAME] [--no-install]

  --quick         the release build's tests only; else also, after them: tests/lint.sh (formatting,
                  headers alone, lock annotations, scripts; where its tools are)
  --sanitizers    and address + undefined behaviour sanitizers on unit, link and fuzz tests, thread
                  sanitizer on cluster tests: twice as long
  --require LIST  skips of tests with these labels (lab, compose, embree, ...) are failures;
                  what those tests need is installed first
  --preset NAME   this preset alone, with all tests that it has
  --no-install    use what is there
END
}

is_quick=no
with_sanitizers=no
is_install=yes
require=
only=
while (($# > 0)); do
  case $1 in
    --quick) is_quick=yes && shift ;;
    --sanitizers) with_sanitizers=yes && shift ;;
    --no-install) is_install=no && shift ;;
    --require | --preset)
      if (($# < 2)); then
        echo "run.sh: $1 needs a value (see --help)" >&2
        exit 2
      fi
      if [[ $1 == --require ]]; then require=$2; else only=$2; fi
      shift 2
      ;;
    -h | --help) usage && exit 0 ;;
    *) echo "run.sh: unknown option '$1' (see --help)" >&2 && exit 2 ;;
  esac
done

sets=build,test
for label in ${require//,/ }; do
  case $label in lab | compose | embree) sets+=,$label ;; esac
done
if [[ $is_install == yes ]]; then deploy/install-dependencies.sh --with "$sets"; fi

# More tests than processors run at a time, since tests wait a good part of their time, for windows,
# links and pauses. Twelve are the most, since cluster tests start several processes each.
jobs=$((6 * $(nproc)))
if ((jobs > 12)); then jobs=12; fi
began=$SECONDS
failed=()
summaries=()

summary_line() {  # its argument is the file with ctest's output
  grep -E '^[0-9]+% tests passed, [0-9]+ tests? failed out of [0-9]+' "$1" | tail -n 1 || true
}

# Builds a preset and runs its tests; the skips are kept for the end. Arguments: preset, label
# expression ("" for all), --require list, targets.
run_preset() {
  local preset=$1 labels=$2 needed=$3 folder=build/$1 code=0
  echo "== $preset: building"
  if ! deploy/build.sh --preset "$preset" --tests "${@:4}"; then
    failed+=("$preset: build")
    return 0
  fi
  local choice=() wrap=()
  # Where the system spreads addresses too widely, the thread sanitizer cannot map its own memory.
  if [[ $preset == tsan ]] && setarch -R true 2>/dev/null; then wrap=(setarch -R); fi
  if [[ -n $labels ]]; then choice=(-L "$labels"); fi
  echo "== $preset: testing"
  "${wrap[@]}" ctest --test-dir "$folder" --output-on-failure -j "$jobs" "${choice[@]}" --no-tests=error \
    --test-output-size-passed 200000 --output-junit run.xml 2>&1 | tee "$folder/run.log" || code=$?
  if ((code != 0)); then failed+=("$preset: tests"); fi
  ctest --test-dir "$folder" --show-only=json-v1 >"$folder/tests.json"
  if ! python3 tests/list_skipped.py "$folder/run.xml" "$folder/tests.json" \
    ${needed:+--require "$needed"} >"$folder/skipped.txt"; then
    failed+=("$preset: required tests skipped")
  fi
  summaries+=("$preset")
}

if [[ -n $only ]]; then
  run_preset "$only" "" "$require"
else
  run_preset release "" "$require"
fi
if [[ -z $only && $with_sanitizers == yes ]]; then
  export ASAN_OPTIONS=detect_stack_use_after_return=1 UBSAN_OPTIONS=print_stacktrace=1
  export LSAN_OPTIONS=suppressions=$PWD/tests/leaks_elsewhere.txt:print_suppressions=0
  run_preset asan '^(unit|links|fuzz)$' "" tests_unit tests_links tests_fuzz programs
  export TSAN_OPTIONS="halt_on_error=1 second_deadlock_stack=1"
  run_preset tsan '^cluster-small$' "" tests_cluster-small programs
fi
if [[ -z $only && $is_quick == no ]]; then
  echo "== lint"
  code=0
  tests/lint.sh || code=$?
  case $code in
    0) lint="nothing found" ;;
    77) lint="skipped: git or a tool is missing (deploy/install-dependencies.sh --with lint)" ;;
    *) lint=failed && failed+=("lint") ;;
  esac
fi

echo
echo "== after $((SECONDS - began)) s"
for preset in "${summaries[@]}"; do
  echo "$preset: $(cat "build/$preset/skipped.txt")"
done
if [[ -n ${lint:-} ]]; then echo "lint: $lint"; fi
for ((i = ${#summaries[@]} - 1; i >= 0; --i)); do  # the summary of the release build comes last
  echo "${summaries[i]}:"
  summary_line "build/${summaries[i]}/run.log"
done
if ((${#failed[@]} > 0)); then
  printf 'FAILED: %s\n' "${failed[@]}"
  exit 1
fi
