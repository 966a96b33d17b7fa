#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# Installs the Debian 12 packages that Tessera needs. It asks dpkg first, and touches nothing, the
# network included, when all of them are there.
set -euo pipefail

usage() {
  cat <<'END'
Usage: deploy/install-dependencies.sh [--with SET[,SET...]] [--list]

  build    compiler, CMake and libraries (default)
  test     what the tests need besides: test libraries, python3, a virtual screen and a hand on it, image tools
  cad      Open CASCADE, for STEP and IGES files (90 MB); without it they are not read
  lab      network and ssh tests: iproute2, openssh
  compose  the container test: podman, docker-compose, debootstrap
  embree   the reference that comparisons of rays need
  lint     clang: lock annotations, fuzz targets, formatting, checks; shellcheck
  runtime  what installed programs need to run (no compilers)
  all      everything above

Sets may be given together. --list prints the packages and installs nothing.
Needs root or sudo, only where something is missing. APT_OPTIONS is passed on to apt-get.
END
}

packages_of() {  # prints the packages of a set
  case $1 in
    build)
      echo g++ cmake ninja-build pkg-config ccache mold libasio-dev libssl-dev openssl \
        libprotobuf-dev protobuf-compiler libspdlog-dev libfmt-dev libopenimageio-dev openimageio-tools \
        libglfw3-dev libepoxy-dev libopengl-dev libgl-dev libimgui-dev libgl1-mesa-dri libhwy-dev \
        libtbb-dev libcli11-dev libtomlplusplus-dev libassimp-dev \
        nlohmann-json3-dev libdraco-dev libmeshoptimizer-dev liblz4-dev libzstd-dev
      ;;
    test)
      echo libgtest-dev libgmock-dev python3 faketime xvfb xauth xdotool imagemagick procps devscripts
      ;;
    cad)
      echo libocct-data-exchange-dev libocct-modeling-algorithms-dev libocct-modeling-data-dev \
        libocct-foundation-dev libocct-ocaf-dev
      ;;
    lab) echo python3 iproute2 openssh-server openssh-client procps valgrind ;;
    compose) echo podman runc iptables netavark aardvark-dns docker-compose debootstrap python3 ;;
    embree) echo libembree-dev ;;
    lint) echo clang-14 clang-format-14 clang-tidy-14 git libclang-rt-14-dev shellcheck ;;
    runtime)
      echo libprotobuf32 libspdlog1.10 libfmt9 libssl3 libhwy1 libtbb12 libopenimageio2.4 libglfw3 \
        libepoxy0 libopengl0 libgl1 libgl1-mesa-dri libassimp5 libstb0 \
        libdraco7 libmeshoptimizer2d libtomlplusplus3 liblz4-1 libzstd1
      ;;
    *)
      echo "install-dependencies.sh: no set '$1' (build, test, cad, lab, compose, embree, lint, runtime, all)" >&2
      return 2
      ;;
  esac
}

sets=()
is_list=no
while (($# > 0)); do
  case $1 in
    --with)
      if (($# < 2)); then
        echo "install-dependencies.sh: --with needs a set (see --help)" >&2
        exit 2
      fi
      IFS=, read -r -a given <<<"$2"
      sets+=("${given[@]}")
      shift 2
      ;;
    --list) is_list=yes && shift ;;
    -h | --help) usage && exit 0 ;;
    *)
      echo "install-dependencies.sh: unknown option '$1' (see --help)" >&2
      exit 2
      ;;
  esac
done
if ((${#sets[@]} == 0)); then sets=(build); fi

wanted=()
for set_name in "${sets[@]}"; do
  if [[ $set_name == all ]]; then
    members=(build test cad lab compose embree lint runtime)
  else
    members=("$set_name")
  fi
  for member in "${members[@]}"; do
    words=$(packages_of "$member") || exit 2
    read -r -a found <<<"$words"
    wanted+=("${found[@]}")
  done
done
mapfile -t wanted < <(printf '%s\n' "${wanted[@]}" | sort -u)

if [[ $is_list == yes ]]; then
  printf '%s\n' "${wanted[@]}"
  exit 0
fi

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
  echo "install-dependencies.sh: this is not Debian; install the counterparts of: ${wanted[*]}" >&2
  exit 1
fi

installed=$(dpkg-query -W -f '${db:Status-Status} ${Package}\n' "${wanted[@]}" 2>/dev/null |
  sed -n 's/^installed //p' || true)
missing=()
for package in "${wanted[@]}"; do
  grep -qxF -- "$package" <<<"$installed" || missing+=("$package")
done
if ((${#missing[@]} == 0)); then
  echo "packages: all ${#wanted[@]} of ${sets[*]} are installed"
  exit 0
fi

as_root=()
if [[ $(id -u) != 0 ]]; then
  if ! command -v sudo >/dev/null; then
    echo "install-dependencies.sh: as root, run: apt-get install --no-install-recommends ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi
# shellcheck disable=SC1091
if [[ $(. /etc/os-release 2>/dev/null && echo "${ID:-}${VERSION_ID:-}") != debian12 ]]; then
  echo "packages: the names are those of Debian 12; this system is another, they may be missing"
fi

echo "packages: installing ${missing[*]}"
read -r -a apt_options <<<"${APT_OPTIONS:-}"
apt() { "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq "${apt_options[@]}" "$@"; }
log=$(mktemp)
trap 'rm -f "$log"' EXIT
if ! { apt update && apt install -y --no-install-recommends "${missing[@]}"; } >"$log" 2>&1 </dev/null; then
  tail -n 20 "$log" >&2
  echo "install-dependencies.sh: apt-get failed; is the network there, and are the sources those of Debian 12?" >&2
  exit 1
fi
echo "packages: installed ${#missing[@]}"
