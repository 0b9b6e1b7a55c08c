#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# A job in a build: gets scanmill, runs the job, collects what the build publishes, and ends with scanmill's exit code, so
# that 3 (a scan failed) and 4 (a gate failed) fail the build.
# usage: run_job.sh JOB OUT PUBLISH [options of scanmill run]
#   JOB      job file below the current folder
#   OUT      output folder; keep it between builds, and only what changed is made again
#   PUBLISH  folder for junit.xml, report.html, summary.md, run.json, scanmill.prom and the pages of the scans
# Where scanmill comes from, the first of these that is set:
#   SCANMILL        path of the program
#   SCANMILL_IMAGE  image, run by SCANMILL_ENGINE (docker or podman, whichever is there); pulled unless it is there
#   SCANMILL_SOURCE sources, of which the image is built
set -eu

[ $# -ge 3 ] || { sed -n 's/^# usage: /usage: /p' "$0" >&2; exit 2; }
job=$1 out=$2 publish=$3
shift 3
mkdir -p "$out" "$publish"
out=$(cd "$out" && pwd) publish=$(cd "$publish" && pwd)
summary=$publish/summary.md
rm -f "$summary"

engine() {
  for one in ${SCANMILL_ENGINE:-docker podman}; do
    command -v "$one" >/dev/null && { echo "$one"; return; }
  done
  echo "found neither docker nor podman; install one, or set SCANMILL to a program" >&2
  exit 2
}

if [ -z "${SCANMILL:-}" ]; then
  run=$(engine)
  if [ -z "${SCANMILL_IMAGE:-}" ]; then
    [ -n "${SCANMILL_SOURCE:-}" ] || { echo "set SCANMILL, SCANMILL_IMAGE or SCANMILL_SOURCE" >&2; exit 2; }
    SCANMILL_IMAGE=localhost/scanmill:ci
    "$run" build -f "$SCANMILL_SOURCE/docker/Dockerfile" -t "$SCANMILL_IMAGE" "$SCANMILL_SOURCE"
  fi
fi

code=0
if [ -n "${SCANMILL:-}" ]; then
  GITHUB_STEP_SUMMARY=$summary "$SCANMILL" run "$job" --out "$out" --progress plain "$@" || code=$?
else
  # The folder of the build is mounted where it is, so that paths in messages lead there; nothing but OUT is written.
  "$run" run --rm --network none --read-only --user "$(id -u):$(id -g)" --tmpfs /tmp \
    -v "$PWD:$PWD:ro" -v "$out:$out" -v "$publish:$publish" -w "$PWD" -e "GITHUB_STEP_SUMMARY=$summary" \
    "$SCANMILL_IMAGE" run "$job" --out "$out" --progress plain "$@" || code=$?
fi

for file in junit.xml report.html run.json scanmill.prom; do
  [ ! -f "$out/$file" ] || cp "$out/$file" "$publish/$file"
done
if [ -d "$out/scans" ]; then
  rm -rf "$publish/scans"
  (cd "$out" && find scans \( -name report.html -o -name 'preview-*.png' \) -print) | while IFS= read -r page; do
    mkdir -p "$publish/$(dirname "$page")"
    cp "$out/$page" "$publish/$page"
  done
fi
# The build's own page, where it has one.
if [ -n "${GITHUB_STEP_SUMMARY:-}" ] && [ -f "$summary" ]; then cat "$summary" >>"$GITHUB_STEP_SUMMARY"; fi

case $code in
  0) echo "all good" ;;
  3) echo "a scan failed: see $publish/report.html" ;;
  4) echo "a gate failed: see $publish/report.html" ;;
  *) echo "scanmill ended with $code" ;;
esac
exit "$code"
