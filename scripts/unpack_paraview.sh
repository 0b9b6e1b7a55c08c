#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Debian's ParaView beside the system: its Python module conflicts with python3-vtk9, which other tests need, so packages are
# unpacked into a folder and never installed. About 160 MB to fetch, 900 MB unpacked. Does nothing when it is there.
# usage: unpack_paraview.sh FOLDER      makes FOLDER/pvpython
set -eu

[ $# -eq 1 ] || { echo "usage: $0 FOLDER" >&2; exit 2; }
case "$1" in /*) folder=$1 ;; *) folder=$PWD/$1 ;; esac
[ ! -x "$folder/pvpython" ] || exit 0
command -v apt-get >/dev/null || { echo "This is no Debian system; ParaView's reader is not tried." >&2; exit 0; }

packages=$(apt-get install --simulate --no-install-recommends python3-paraview 2>/dev/null | sed -n 's/^Inst \([^ ]*\).*/\1/p')
if [ -z "$packages" ]; then
  echo "apt-get offers no python3-paraview; ParaView's reader is not tried." >&2
  exit 0
fi
echo "Unpacking ParaView into $folder"
rm -rf "$folder"
mkdir -p "$folder/packages" "$folder/root"
# shellcheck disable=SC2086  # the list is words
if ! (cd "$folder/packages" && apt-get download -qq $packages 2>/dev/null); then
  rm -rf "$folder"
  echo "The packages of ParaView cannot be fetched; its reader is not tried." >&2
  exit 0
fi
for package in "$folder"/packages/*.deb; do dpkg-deb -x "$package" "$folder/root"; done
rm -rf "$folder/packages"

libraries=$(find "$folder/root" -name '*.so*' -exec dirname {} + | sort -u | tr '\n' ':')
modules=$folder/root/usr/lib/python3/dist-packages:$folder/root/usr/lib/python3.11/dist-packages
cat > "$folder/.pvpython" <<END
#!/bin/sh
LD_LIBRARY_PATH='$libraries' PYTHONPATH='$modules' exec '$folder/root/usr/bin/pvpython' "\$@"
END
chmod +x "$folder/.pvpython"
mv "$folder/.pvpython" "$folder/pvpython"  # last, so that an interrupted unpacking looks like none
