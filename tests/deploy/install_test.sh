#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# The install tree works without the build tree: programs find their plug-in and importer, an
# application that links the session library renders, units are well-formed.
# Usage: install_test.sh BUILD_FOLDER COMPILER
set -euo pipefail
build=$1 compiler=$2
source=$(realpath "$(dirname "$0")")
prefix=$(mktemp -d)
trap 'rm -rf "$prefix"' EXIT
cmake --install "$build" --prefix "$prefix" >"$prefix/install.log"

fail() {
  echo "FAILED: $1"
  exit 1
}
for program in tessera-master tessera-slave tessera-keys tessera-import; do
  "$prefix/bin/$program" --version || fail "$program does not start"
done
[[ -f $prefix/lib/tessera/tessera_image_oiio.so ]] || fail "the plug-in is not installed"
ls "$prefix"/lib/systemd/system/tessera-{master,slave}.service "$prefix/lib/sysusers.d/tessera.conf"

cd "$prefix"
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >scene.obj
bin/tessera-master render scene.obj -o out.png --size 32x32 --quiet
[[ -s out.png ]] || fail "no picture"

# An application outside this tree finds the package, links the library and renders.
mkdir app
cp "$source/app.cpp" "$source/app.cmake" app/
mv app/app.cmake app/CMakeLists.txt
if ! { cmake -S app -B app/build -G Ninja -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_CXX_COMPILER="$compiler" && ninja -C app/build; } >app.log 2>&1; then
  cat app.log
  fail "the example application does not build"
fi
app/build/app || fail "the example application does not render"

# A daemon that a limit on starts has ended does not come back when what was wrong is mended.
for unit in lib/systemd/system/*.service; do
  grep -qx 'StartLimitIntervalSec=0' "$unit" || fail "$unit has a limit on starts"
done

# Units are checked where systemd is installed. Their paths of programs are replaced by those of this prefix.
if command -v systemd-analyze >/dev/null; then
  for unit in lib/systemd/system/*.service; do
    sed -i "s|/usr/bin/|$prefix/bin/|" "$unit"
    systemd-analyze verify --man=no "$unit" >verify.log 2>&1 || true
    if grep -E "${unit##*/}.*(Unknown|Invalid|Failed to parse|not executable)" verify.log; then
      fail "$unit is not well-formed"
    fi
  done
fi
echo "the install tree works"
