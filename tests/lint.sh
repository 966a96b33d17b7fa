#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Asks tools about the sources, which do not run. Exit code 0: they found nothing; 1: something; 77: a tool is missing.
set -euo pipefail
cd "$(dirname "$0")/.."

usage() {
  cat <<'END'
Usage: tests/lint.sh [WHAT...] [--since COMMIT]

  format    C++ is formatted by clang-format-14 and .clang-format; shows what differs
  headers   every header compiles alone, with the options of its folder (some minutes)
  locks     clang's lock annotations, in sources that see a mutex (some minutes)
  shell     shellcheck on all scripts
  tidy      the checks of .clang-tidy, by clang-tidy-14 (ten minutes on two cores; --since: changed sources alone)

Without WHAT: all but tidy. headers needs a configured tree (deploy/build.sh).
END
}

what=()
since=
while (($# > 0)); do
  case $1 in
    format | headers | locks | shell | tidy) what+=("$1") && shift ;;
    --since)
      if (($# < 2)); then echo "lint.sh: --since needs a commit" >&2 && exit 2; fi
      since=$2 && shift 2
      ;;
    -h | --help) usage && exit 0 ;;
    *) echo "lint.sh: unknown '$1' (see --help)" >&2 && exit 2 ;;
  esac
done
if ((${#what[@]} == 0)); then what=(format headers locks shell); fi

need() {
  if ! command -v "$1" >/dev/null; then
    echo "lint.sh: $1 is not installed (deploy/install-dependencies.sh --with lint)" >&2
    exit 77
  fi
}

if ! git ls-files >/dev/null 2>&1; then
  echo "lint.sh: git does not list the files of this tree" >&2
  exit 77
fi

sources() {  # prints the files of the tree (with --since: the changed ones) that match these patterns
  if [[ -n $since ]]; then
    git diff --name-only --diff-filter=d "$since" -- "$@"
  else
    git ls-files -- "$@"
  fi
}

configure_for_clang() {  # a tree of clang's options, with what protoc makes
  if [[ ! -f build/clang-annotations/compile_commands.json ]]; then
    cmake --preset clang-annotations >/dev/null
    ninja -C build/clang-annotations tessera_proto >/dev/null
  fi
}

status=0
for part in "${what[@]}"; do
  echo "== $part"
  case $part in
    format)
      need clang-format-14
      sources '*.h' '*.cpp' | xargs -r clang-format-14 --dry-run --Werror || status=1
      ;;
    headers)
      sources '*.h' | python3 tests/tidy/headers_alone.py build/release/compile_commands.json || status=1
      ;;
    locks)
      need clang++-14
      configure_for_clang
      python3 tests/tidy/lock_annotations.py build/clang-annotations/compile_commands.json || status=1
      ;;
    shell)
      need shellcheck
      sources '*.sh' .ci/run | xargs -r shellcheck || status=1
      ;;
    tidy)
      need clang-tidy-14
      configure_for_clang
      sources 'common/*.cpp' 'slave/*.cpp' 'master/*.cpp' 'deploy/*.cpp' |
        xargs -r -n 1 -P "$(nproc)" clang-tidy-14 --quiet -p build/clang-annotations || status=1
      ;;
  esac
done
if ((status == 0)); then echo "nothing found: ${what[*]}"; fi
exit $status
