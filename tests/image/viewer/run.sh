#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Runs the viewer's tests on a virtual display with software rendering.
# Usage: run.sh VIEWER_TEST NO_DISPLAY_TEST. Exit 77: skipped, with the reason.
set -euo pipefail
viewer_test=$1 no_display_test=$2

echo "without a display:"
env -u DISPLAY -u WAYLAND_DISPLAY "$no_display_test" display
DISPLAY=:4095 "$no_display_test" display

for tool in xvfb-run xauth; do
  if ! command -v "$tool" >/dev/null; then
    echo "skipped: $tool is not installed (apt-get install xvfb xauth)"
    exit 77
  fi
done
export LIBGL_ALWAYS_SOFTWARE=1
on_screen() { xvfb-run -a -s "-screen 0 1280x800x24 -noreset" "$@"; }

echo "with an old OpenGL:"
on_screen env MESA_GL_VERSION_OVERRIDE=2.1 "$no_display_test" opengl
on_screen "$viewer_test"
