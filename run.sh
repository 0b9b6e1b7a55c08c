#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Sets up what is missing, builds scanmill and runs a job (default: the sample job).
# usage: ./run.sh [JOB [options of scanmill run]]
set -eu

root=$(cd "$(dirname "$0")" && pwd)
job=$root/jobs/demo.yaml
case "${1:-}" in
  "" | -*) ;;
  *) job=$1; shift ;;
esac

"$root/scripts/install_packages.sh" build

build=$root/build/release
# A build folder that exists keeps its settings (the tests may be part of it).
if [ ! -f "$build/build.ninja" ]; then
  echo "Configuring $build"
  (cd "$root" && cmake --preset release -DSCANMILL_TESTS=OFF -DSCANMILL_BENCH=OFF)
fi
echo "Building $build/scanmill"
cmake --build "$build" --target scanmill
scanmill=$build/scanmill

# The sample archive: made once, in a folder beside it, so that an interrupted making leaves nothing that looks done.
if [ "$(realpath "$job")" = "$root/jobs/demo.yaml" ] && [ ! -d "$root/archive/demo" ]; then
  echo "Making the sample archive $root/archive/demo"
  rm -rf "$root"/archive/.demo.*
  making=$root/archive/.demo.$$
  mkdir -p "$making"
  for part in figurine handset; do
    "$scanmill" simulate "$root/jobs/demo/$part.plan.yaml" --object "$part" --out "$making/$part"
  done
  mv -T "$making" "$root/archive/demo"
fi

name=$(basename "$job")
exec "$scanmill" run "$job" --out "$root/out/${name%.*}" "$@"
