#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Runs shellcheck on all shell scripts, and --help, which says the usage, and an unknown option of each that a person
# runs. Looks that keys in ./cluster stay there.
# Usage: scripts_test.sh SOURCE_FOLDER. Exit 77: skipped, with the reason.
set -euo pipefail
cd "$1"
for script in deploy/quickstart.sh deploy/install-dependencies.sh deploy/build.sh deploy/launch-slaves.sh tests/run.sh tests/fuzz.sh tests/nightly.sh; do
  help=$("$script" --help) || { echo "FAILED: $script --help" && exit 1; }
  if ! grep -q "^Usage: .*${script##*/}" <<<"$help"; then
    echo "FAILED: $script --help does not say the usage: $help"
    exit 1
  fi
  code=0
  "$script" --no-such-option >/dev/null 2>&1 || code=$?
  if ((code != 2)); then
    echo "FAILED: $script --no-such-option ends with $code, not 2"
    exit 1
  fi
done
# The README makes keys in ./cluster: they must neither be committed nor go into an image.
if ! grep -qx /cluster/ .gitignore || ! grep -qx cluster .dockerignore; then
  echo "FAILED: .gitignore and .dockerignore do not both name cluster"
  exit 1
fi
if ! command -v shellcheck >/dev/null; then
  echo "skipped: shellcheck is not installed (deploy/install-dependencies.sh --with lint)"
  exit 77
fi
mapfile -t scripts < <(find . -path ./build -prune -o -path ./out -prune -o -name '*.sh' -print)
shellcheck "${scripts[@]}" .ci/run
echo "${#scripts[@]} scripts"
