#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# A slave links neither OpenImageIO nor Assimp nor a window library. Usage: slave_links_test.sh TESSERA_SLAVE
set -euo pipefail
libraries=$(ldd "$1")
echo "$libraries"
grep -q libprotobuf <<<"$libraries"  # ldd has listed libraries
! grep -iE 'openimageio|glfw|libGL|epoxy|assimp|imgui|libX11' <<<"$libraries"
