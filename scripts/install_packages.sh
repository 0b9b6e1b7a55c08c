#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Installs the Debian 12 packages that are missing; does nothing, and needs no network, when none is.
# usage: install_packages.sh build|test|all
set -eu

build="g++ cmake ninja-build ccache pkg-config
  libopenvdb-dev libboost-iostreams-dev libimath-dev libblosc-dev libtbb-dev libeigen3-dev libhdf5-dev
  libcli11-dev libyaml-cpp-dev nlohmann-json3-dev libssl-dev zlib1g-dev"
test="libgtest-dev python3 python3-numpy python3-h5py python3-vtk9 python3-jsonschema python3-yaml strace
  python3-ezdxf lib3mf1 admesh libopenvdb-tools slurmctld slurmd slurm-client slurm-wlm-basic-plugins"
all="libocct-foundation-dev libocct-modeling-data-dev libocct-modeling-algorithms-dev libocct-ocaf-dev libocct-data-exchange-dev
  chromium buildah podman runc debootstrap"

case "${1:-}" in
  build) wanted=$build ;;
  test) wanted="$build $test" ;;
  all) wanted="$build $test $all" ;;
  *) echo "usage: $0 build|test|all" >&2; exit 2 ;;
esac

if ! command -v dpkg-query >/dev/null; then
  echo "This is no Debian system; install what $0 lists by hand." >&2
  exit 0
fi
missing=
for package in $wanted; do
  status=$(dpkg-query -W -f='${Status}' "$package" 2>/dev/null || true)
  [ "$status" = "install ok installed" ] || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

echo "Installing:$missing"
as_root=
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "Not root, and there is no sudo; as root: apt-get install$missing" >&2; exit 1; }
  as_root=sudo
fi
$as_root apt-get update
# shellcheck disable=SC2086  # the list is words
$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends $missing
