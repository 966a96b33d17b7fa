#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Builds the preset `fuzz` and lets libFuzzer look for inputs that break a target, each target for so long.
# Exit code 0: none was found; 1: a finding, or a target that did not run; 2: wrong usage; 77: clang-14 is missing.
set -euo pipefail
cd "$(dirname "$0")/.."

usage() {
  cat <<'END'
Usage: tests/fuzz.sh [--seconds N] [--only TARGET,...] [--jobs N] [--no-build] [--table] [--json FILE] [--merge]

  --seconds N     so long for each target (default 60)
  --only LIST     these targets alone (--table names them all)
  --jobs N        so many targets at a time (default: one for each processor)
  --no-build      run what is built
  --table         run nothing; print what all runs of the targets as they are built now came to
  --json FILE     the same as a result for tests/bench/tables.py
  --merge         run nothing; copy new inputs, of 1 KiB at most, that reach new places into the corpora of this tree

New inputs are kept in build/fuzz/corpus, what broke a target in build/fuzz/findings. To see a finding again:
build/fuzz/bin/TARGET build/fuzz/findings/FILE. Whoever mends it adds the file to the target's corpus.
END
}

seconds=60
only=
jobs=$(nproc)
slow_seconds=10        # of processor time for one input: a finding
merged_bytes_max=1024  # of an input that --merge takes into the tree
failed=0
build=yes
task=run
json=
need_value() { if (($2 < 2)); then echo "fuzz.sh: $1 needs a value (see --help)" >&2 && exit 2; fi; }
while (($# > 0)); do
  case $1 in
    --seconds) need_value "$1" $# && seconds=$2 && shift 2 ;;
    --only) need_value "$1" $# && only=$2 && shift 2 ;;
    --jobs) need_value "$1" $# && jobs=$2 && shift 2 ;;
    --json) need_value "$1" $# && json=$2 && task=table && shift 2 ;;
    --no-build) build=no && shift ;;
    --table) task=table && shift ;;
    --merge) task=merge && shift ;;
    -h | --help) usage && exit 0 ;;
    *) echo "fuzz.sh: unknown option '$1' (see --help)" >&2 && exit 2 ;;
  esac
done
for number in "$seconds" "$jobs"; do
  if ! [[ $number =~ ^[1-9][0-9]{0,6}$ ]]; then echo "fuzz.sh: '$number' is not a number" >&2 && exit 2; fi
done

folder=build/fuzz
if ! command -v clang++-14 >/dev/null; then
  echo "skipped: clang-14 is not installed (deploy/install-dependencies.sh --with lint)"
  exit 77
fi
if [[ $build == yes && $task == run ]]; then deploy/build.sh --preset fuzz --tests tests_fuzz tessera-import; fi
if [[ ! -f $folder/fuzz_targets.txt ]]; then echo "fuzz.sh: nothing is built in $folder" >&2 && exit 1; fi

declare -A corpus_of bytes_of
names=()
while read -r name bytes corpus; do
  corpus_of[$name]=$corpus
  bytes_of[$name]=$bytes
  if [[ -z $only || ,$only, == *,$name,* ]]; then names+=("$name"); fi
done < <(sed '/^$/d' "$folder/fuzz_targets.txt")
for name in ${only//,/ }; do
  if [[ -z ${corpus_of[$name]:-} ]]; then echo "fuzz.sh: no target '$name' (see --table)" >&2 && exit 2; fi
done

if [[ $task == table ]]; then
  exec python3 tests/fuzz/fuzz_table.py "$folder" ${json:+--json "$json"} "${names[@]}"
fi

mkdir -p "$folder"/{corpus,findings,logs}
export ASAN_OPTIONS=detect_stack_use_after_return=1:allocator_may_return_null=1
export UBSAN_OPTIONS=print_stacktrace=1
export LSAN_OPTIONS=suppressions=$PWD/tests/leaks_elsewhere.txt:print_suppressions=0
# Readers are given files. Where memory can hold them, no disk is worn.
if [[ -z ${TMPDIR:-} && -w /dev/shm ]]; then export TMPDIR=/dev/shm; fi

# The tree keeps what reaches a place of the program that nothing else there does, where a small input shows it.
merge_target() {
  local name=$1 corpus=${corpus_of[$1]} small=$folder/small/$1
  rm -rf "$small" && mkdir -p "$small"
  find "$folder/corpus/$name" -type f -size "-$((merged_bytes_max + 1))c" -exec cp -t "$small" {} +
  echo "$name: $("$folder/bin/$name" -set_cover_merge=1 -use_counters=0 -max_len="${bytes_of[$name]}" "$corpus" "$small" 2>&1 |
    sed -n 's/^MERGE-OUTER: \([0-9]* new files\).*/\1/p' | tail -n 1)"
  rm -r "$small"
}

if [[ $task == merge ]]; then
  for name in "${names[@]}"; do
    if [[ ${corpus_of[$name]} != "$PWD"/tests/* ]]; then continue; fi  # a corpus that the build writes
    mkdir -p "$folder/corpus/$name"
    merge_target "$name" || { echo "fuzz.sh: $name: no merge" >&2 && failed=1; }
  done
  git status --short tests/fuzz | wc -l | sed 's/$/ new or changed in tests\/fuzz/'
  exit $failed
fi

# Prints the inputs of a target that take too long, and forgets the others that libFuzzer took for slow: it looks at the
# clock, and a busy machine makes everything slow.
slow_inputs() {
  local name=$1 input took TIMEFORMAT=%U
  for input in "$folder/findings/$name"-slow-unit-*; do
    if [[ ! -f $input ]]; then continue; fi
    took=$({ time "$folder/bin/$name" "$input" >/dev/null 2>&1; } 2>&1)
    if ((${took%.*} >= slow_seconds)); then echo "$input: $took s of processor time"; else rm "$input"; fi
  done
}

run_target() {  # runs one target; its line of the log of runs says which program it was
  local name=$1 log=$folder/logs/$1.log program=$folder/bin/$1 began=$SECONDS digest slow
  digest=$(sha256sum "$program" | cut -c 1-16)
  mkdir -p "$folder/corpus/$name"
  # Without -entropic=0 most of the time goes to libFuzzer's own search among rare features, of which peers have many.
  "$program" -max_total_time="$seconds" -entropic=0 -timeout=120 -rss_limit_mb=4096 -max_len="${bytes_of[$name]}" \
    -report_slow_units="$slow_seconds" -print_final_stats=1 -print_funcs=0 \
    -artifact_prefix="$folder/findings/$name-" "$folder/corpus/$name" "${corpus_of[$name]}" >"$log" 2>&1
  local code=$? executions
  slow=$(slow_inputs "$name")
  if [[ -n $slow && $code == 0 ]]; then code=70; fi
  executions=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log" | tail -n 1)
  printf '%s %s %s %s %s\n' "$name" "$digest" "${executions:-0}" \
    "$((SECONDS - began))" "$((code == 0 ? 0 : 1))" >>"$folder/runs.txt"
  if ((code == 0)); then
    echo "$name: ${executions:-0} executions"
  else
    echo "$name: FOUND (exit code $code): $log"
    if [[ -n $slow ]]; then echo "  slow: $slow"; fi
    grep -E -m 3 'ERROR|runtime error|Test unit written|what\(\)' "$log" | sed 's/^/  /'
  fi
  return "$code"
}

running=0
for name in "${names[@]}"; do
  if ((running >= jobs)); then
    wait -n || failed=1
    running=$((running - 1))
  fi
  # errexit would end the function at the first finding.
  (set +e && run_target "$name") &
  running=$((running + 1))
done
for ((; running > 0; --running)); do wait -n || failed=1; done
python3 tests/fuzz/fuzz_table.py "$folder" "${names[@]}" || failed=1
echo "new inputs: $folder/corpus; tests/fuzz.sh --merge copies those that reach new places into the tree"
exit $failed
