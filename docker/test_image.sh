#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Builds the image and proves what README.md promises: small, no compiler, any user, read-only root, no network, read-only
# input; the same bytes as outside; SIGTERM drains, exits with 143, and the next run goes on.
# usage: test_image.sh SCANMILL [STORE]
#   SCANMILL  the program built outside, to compare with
#   STORE     folder that keeps base and layers for the next time (/var/tmp/scanmill-images)
# Needs root, buildah, podman and runc, and for the base debootstrap; exits with 77 where one is missing. Of the
# environment: BASE_ROOT, a root folder of debootstrap in place of a new one; CCACHE, a folder of ccache to build with.
set -eu

[ $# -ge 1 ] || { sed -n 's/^# usage: /usage: /p' "$0" >&2; exit 2; }
scanmill=$1 store=${2:-/var/tmp/scanmill-images}
root=$(cd "$(dirname "$0")/.." && pwd)
base=docker.io/library/debian:bookworm-slim image=localhost/scanmill:test
limit_mib=120

[ "$(id -u)" -eq 0 ] || { echo "skipped: root is needed to build and run images here"; exit 77; }
for program in buildah podman runc; do
  command -v "$program" >/dev/null || { echo "skipped: $program is not installed (apt-get install buildah podman runc debootstrap)"; exit 77; }
done

mkdir -p "$store/layers" "$store/run"
cat >"$store/storage.conf" <<CONF
[storage]
driver = "overlay"
graphroot = "$store/layers"
runroot = "$store/run"
CONF
# For machines without systemd and with few rights, such as builders are.
cat >"$store/containers.conf" <<CONF
[containers]
default_ulimits = ["nofile=1024:1024", "nproc=4096:4096"]
netns = "host"
log_driver = "k8s-file"
[engine]
runtime = "runc"
cgroup_manager = "cgroupfs"
events_logger = "file"
helper_binaries_dir = ["/usr/lib/podman"]
CONF
export CONTAINERS_STORAGE_CONF="$store/storage.conf" CONTAINERS_CONF="$store/containers.conf"

work=$(mktemp -d /tmp/scanmill-image.XXXXXX)
name=scanmill-test-$$
clean() {
  podman rm -f "$name" >/dev/null 2>&1 || true
  rm -rf "$work"
}
trap clean EXIT

if ! buildah inspect --type image "$base" >/dev/null 2>&1; then
  echo "== base: $base by debootstrap"
  command -v debootstrap >/dev/null || { echo "skipped: debootstrap is not installed"; exit 77; }
  folder=${BASE_ROOT:-$work/base}
  [ -n "${BASE_ROOT:-}" ] || debootstrap --variant=minbase bookworm "$folder" >"$work/debootstrap.log"
  mkdir "$work/context"
  tar -C "$folder" --one-file-system --exclude=./var/cache/apt/archives/*.deb --exclude=./var/lib/apt/lists/* -cf "$work/context/base.tar" .
  printf 'FROM scratch\nADD base.tar /\nCMD ["bash"]\n' >"$work/context/Dockerfile"
  buildah bud --isolation chroot -q -t "$base" "$work/context"
fi

echo "== build"
set --
[ -z "${CCACHE:-}" ] || set -- -v "$CCACHE:/root/.cache/ccache"
[ -z "${CCACHE_CONFIG:-}" ] || set -- "$@" -v "$CCACHE_CONFIG:/root/.config/ccache"
version=$(sed -n 's/^project(scanmill VERSION \([0-9.]*\).*/\1/p' "$root/CMakeLists.txt")
buildah bud --isolation chroot --pull-never --layers "$@" --build-arg "VERSION=$version" -f "$root/docker/Dockerfile" -t "$image" "$root" \
  >"$work/build.log" 2>&1 || { tail -30 "$work/build.log"; exit 1; }

# What the image's own layers hold: files of the base that are removed again do not make it smaller.
bytes() { podman image inspect -f '{{.Size}}' "$1"; }
base_mib=$(($(bytes "$base") / 1048576)) image_mib=$(($(bytes "$image") / 1048576))
echo "size: base $base_mib MiB, image $image_mib MiB, on top of the base $((image_mib - base_mib)) MiB (limit $limit_mib)"
[ $((image_mib - base_mib)) -le $limit_mib ]

label=$(podman image inspect -f '{{index .Labels "org.opencontainers.image.version"}} {{index .Labels "org.opencontainers.image.licenses"}}' "$image")
[ "$label" = "$version Apache-2.0" ] || { echo "labels: found '$label'"; exit 1; }

# The sample job, as run.sh has it.
mkdir "$work/lab"
cp -r "$root/jobs" "$work/lab/jobs"
if [ -d "$root/archive/demo" ]; then
  mkdir "$work/lab/archive"
  cp -r "$root/archive/demo" "$work/lab/archive/demo"
else
  for part in figurine handset; do
    "$scanmill" simulate "$root/jobs/demo/$part.plan.yaml" --object "$part" --out "$work/lab/archive/demo/$part" --quiet
  done
fi
chmod -R a+rX "$work"
inside() { podman run --user 12345:12345 --read-only --read-only-tmpfs=false --network none --cap-drop=all -v "$work/lab:/lab:ro" "$@"; }

echo "== no compiler, nothing to write"
! inside --rm --entrypoint sh "$image" -c 'command -v gcc cc g++ c++ ld cmake ninja make'
! inside --rm --entrypoint sh "$image" -c 'echo x >/x || echo x >/lab/x || echo x >/usr/local/x' 2>/dev/null
[ "$(inside --rm --entrypoint id "$image" -u)" = 12345 ]
[ "$(podman run --rm --entrypoint id "$image" -u)" = 10001 ]
inside --rm "$image" --version | head -1

files() { (cd "$1/scans" && find . -type f ! -name report.html ! -name .state.json | LC_ALL=C sort | xargs sha256sum); }

echo "== the sample job, outside and inside"
(cd "$work/lab" && "$scanmill" run jobs/demo.yaml --out "$work/outside" --quiet --progress none)
mkdir -m 777 "$work/inside"
inside --rm -v "$work/inside:/out" "$image" run /lab/jobs/demo.yaml --out /out --progress none | tail -1
files "$work/outside" >"$work/outside.sums"
files "$work/inside" >"$work/inside.sums"
diff "$work/outside.sums" "$work/inside.sums"
echo "same bytes in $(wc -l <"$work/inside.sums") files"
[ "$(stat -c %u "$work/inside/run.json")" = 12345 ]

echo "== SIGTERM"
fine="--set lattice.bin_mm=0.5"  # so that there is time to stop it
# shellcheck disable=SC2086  # options are words
(cd "$work/lab" && "$scanmill" run jobs/demo.yaml --out "$work/fine" $fine --quiet --progress none)
files "$work/fine" >"$work/fine.sums"
mkdir -m 777 "$work/stopped"
inside -d --name "$name" -v "$work/stopped:/out" "$image" run /lab/jobs/demo.yaml --out /out $fine --threads 1 --progress none >/dev/null
for _ in $(seq 600); do
  [ -z "$(find "$work/stopped/logs" -name '*.log' 2>/dev/null)" ] || break
  sleep 0.05
done
podman stop --time 120 "$name" >/dev/null
code=$(podman inspect -f '{{.State.ExitCode}}' "$name")
podman logs "$name" 2>/dev/null | tail -1
[ "$code" = 143 ] || { echo "exit $code, wanted 143"; exit 1; }
[ "$(grep -c '"state": "done"' "$work/stopped/run.json")" = 1 ] || { echo "what was at work was not brought to its end"; exit 1; }
inside --rm -v "$work/stopped:/out" "$image" run /lab/jobs/demo.yaml --out /out $fine --progress none | tail -1
files "$work/stopped" | diff "$work/fine.sums" -
echo "drained, 143, went on: same bytes"
