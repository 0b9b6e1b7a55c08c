#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Sets up what is missing, builds everything and runs the tests; --all adds the slow ones and the heavy oracles (OCCT, ParaView,
# Chromium).
# usage: ./test.sh [--all]
set -eu

root=$(cd "$(dirname "$0")" && pwd)
case "${1:-}" in
  "") packages=test heavy=OFF select="-LE slow" ;;
  --all) packages=all heavy=ON select="" ;;
  *) echo "usage: $0 [--all]" >&2; exit 2 ;;
esac

"$root/scripts/install_packages.sh" "$packages"

cd "$root"
[ "$heavy" = OFF ] || "$root/scripts/unpack_paraview.sh" "$root/build/release/paraview"
cmake --preset release -DSCANMILL_TESTS=ON -DSCANMILL_BENCH=ON -DSCANMILL_HEAVY_ORACLES=$heavy
cmake --build --preset release
# shellcheck disable=SC2086  # options are words
exec ctest --test-dir build/release --output-on-failure -j "$(nproc)" $select
