#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs everything that takes too long for every change, part by part, and goes on past what fails.
set -uo pipefail
cd "$(dirname "$0")/.." || exit

usage() {
  cat <<'END'
Usage: tests/nightly.sh [--list] [--only PART,...] [--without PART,...] [--logs DIR] [--no-build]

Builds the release preset with its tests, runs each part, and ends with a table. Output of a part goes
to DIR/PART.log (default: build/nightly). Exit code 0: nothing failed; 1: something did; what this
machine cannot run is "skipped", with the reason. --list: the parts and what each one runs.
END
}

# Name, what it runs (for --list and the table), in the order of running.
parts=(
  "faults|the fault matrix with real processes: tests/faults.sh --all"
  "links|links that end at any byte: session_link_storm_test, 1,000 visits for each of its peers"
  "sim|the cluster in virtual time: tessera-sim --seeds 100000"
  "planted|bugs planted on purpose: tests/sim/planted_bugs.py, tests/property/planted/planted_bugs.py"
  "property|what holds for all inputs, at length: tests/long_tests.py -L property"
  "cost|what scenes pay for features that they lack: tests/bench/feature_cost/core_cost.sh"
  "run|every test, lint, sanitizers: tests/run.sh --sanitizers --no-install"
  "fuzz|ten minutes for each fuzz target: tests/fuzz.sh"
  "gallery|every scene that is at hand: tests/gallery/run.py"
  "cad|1,000 damaged CAD files: tests/fuzz/cad/damaged_cad_test.py"
  "clock|a master's clock wrong for 40 s: tests/cluster/clock_test.py --whole"
  "peers|bad peers beside a render, bad files: tests/cluster/bad_peers_test.py, tests/sandbox/bad_files_test.py"
  "versions|peers of other versions and instruction sets: rows F23, F24, and wire_codec_test"
)

only=
without=
logs=build/nightly
is_built=no
fuzz_seconds=600
bin=build/release/bin
while (($# > 0)); do
  case $1 in
    --list)
      for part in "${parts[@]}"; do printf '%-10s %s\n' "${part%%|*}" "${part#*|}"; done
      exit 0
      ;;
    --no-build) is_built=yes && shift ;;
    --only | --without | --logs)
      if (($# < 2)); then
        echo "nightly.sh: $1 needs a value (see --help)" >&2
        exit 2
      fi
      case $1 in
        --only) only=$2 ;;
        --without) without=$2 ;;
        --logs) logs=$2 ;;
      esac
      shift 2
      ;;
    -h | --help) usage && exit 0 ;;
    *) echo "nightly.sh: unknown option '$1' (see --help)" >&2 && exit 2 ;;
  esac
done
for name in ${only//,/ } ${without//,/ }; do
  if ! printf '%s\n' "${parts[@]}" | grep -q "^$name|"; then
    echo "nightly.sh: no part '$name' (see --list)" >&2
    exit 2
  fi
done

# Runs all commands, whatever the first ones say, and names those that failed. Returns: the worst code.
# 77 means that this machine cannot run something.
both() {
  local worst=0 code command broken=()
  for command in "$@"; do
    code=0
    echo "+ $command"
    bash -c "$command" || code=$?
    if ((code != 0 && code != 77)); then broken+=("$command: exit code $code"); fi
    if ((code != 0 && (worst == 0 || worst == 77))); then worst=$code; fi
  done
  if ((${#broken[@]} > 0)); then printf 'FAILED: %s\n' "${broken[@]}"; fi
  return "$worst"
}

# Prints the line of a part's log that says what it came to.
summary_of() {
  local verdict=$1 log=$2 pattern='[^[:space:]]' line
  case $verdict in
    skipped) pattern='^skipped: ' ;;
    FAILED) pattern='FAILED|failed' ;;
  esac
  line=$(grep -E "$pattern" "$log" | tail -n 1)
  if [[ -z $line ]]; then line=$(grep '[^[:space:]]' "$log" | tail -n 1); fi
  cut -c 1-100 <<<"${line:-it said nothing}"
}

run_part() {
  case $1 in
    faults) tests/faults.sh --all --json "$logs/faults.jsonl" --logs "$logs/faults" ;;
    links) TESSERA_LINK_STORM=1000 "$bin/session_link_storm_test" ;;
    sim) "$bin/tessera-sim" --seeds 100000 ;;
    planted) both tests/sim/planted_bugs.py tests/property/planted/planted_bugs.py ;;
    property) python3 tests/long_tests.py build/release -L property ;;
    cost) tests/bench/feature_cost/core_cost.sh ;;
    run) tests/run.sh --sanitizers --no-install ;;
    fuzz) tests/fuzz.sh --seconds "$fuzz_seconds" ;;
    gallery) python3 tests/gallery/run.py --bin "$bin" --out "$logs/gallery" ;;
    cad) python3 tests/long_tests.py build/release -R cad_damaged_files ;;
    clock) python3 tests/cluster/clock_test.py --whole ;;
    peers) both "python3 tests/cluster/bad_peers_test.py" "python3 tests/sandbox/bad_files_test.py" ;;
    versions) both "tests/faults.sh F23 F24" "$bin/wire_codec_test" ;;
  esac
}

mkdir -p "$logs"
export PYTHONUNBUFFERED=1 PYTHONDONTWRITEBYTECODE=1 TESSERA_BIN=$bin
if [[ $is_built == no ]]; then
  echo "== building"
  if ! deploy/build.sh --preset release --tests >"$logs/build.log" 2>&1; then
    tail -n 20 "$logs/build.log"
    echo "nightly.sh: the release preset does not build; see $logs/build.log" >&2
    exit 1
  fi
fi

table=()
failed=0
for part in "${parts[@]}"; do
  name=${part%%|*}
  if [[ -n $only && ,$only, != *,$name,* ]] || [[ ,$without, == *,$name,* ]]; then continue; fi
  echo "== $name: ${part#*|}"
  began=$SECONDS
  code=0
  (set -o pipefail && run_part "$name" 2>&1 | tee "$logs/$name.log" | tail -n 40) || code=$?
  case $code in
    0) verdict=held ;;
    77) verdict=skipped ;;
    *) verdict=FAILED && failed=1 ;;
  esac
  summary=$(summary_of "$verdict" "$logs/$name.log")
  table+=("$(printf '%-10s %-8s %7d s  %s' "$name" "$verdict" $((SECONDS - began)) "$summary")")
done

echo
echo "== the night"
printf '%s\n' "${table[@]}"
exit "$failed"
