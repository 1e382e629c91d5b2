#!/usr/bin/env bash
# Packages in bare systems, made by debootstrap: the archive in one without anything else, Debian's packages by apt in another.
# Both draw a folder of DICOM. Needs root, debootstrap and Debian's mirror, some 3 GB of disk and a few minutes; by hand.
#   bare_roots.sh FOLDER DICOM [archive] [deb]
# FOLDER has the packages of cmake/packages/make.sh. BASE: where the bare system is kept as an archive, made once (default:
# /tmp/tessera-bare.tar); MIRROR: Debian's.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
packages=$(realpath "$1") dicom=$(realpath "$2")
shift 2
parts=("$@")
((${#parts[@]})) || parts=(archive deb)
base=${BASE:-/tmp/tessera-bare.tar} mirror=${MIRROR:-http://deb.debian.org/debian}
if ((EUID != 0)) || ! command -v debootstrap >/dev/null; then
    echo "skipped: needs root and debootstrap"
    exit 77
fi
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
if [[ ! -f $base ]]; then
    debootstrap --variant=minbase bookworm "$root" "$mirror" >"$base.log" || { cat "$base.log"; exit 77; }
    tar -C "$root" -cf "$base" .
fi

new_root() {
    rm -rf "$root"
    mkdir -m 755 "$root"
    tar -C "$root" -xf "$base"
    cp -r "$dicom" "$root/dicom"
    mkdir -m 777 "$root/work"
}
# As nobody, with nothing but the root and /proc, and no network.
as_nobody() {
    unshare --net --pid --fork --mount-proc="$root/proc" chroot --userspec=65534:65534 "$root" /usr/bin/env -i /bin/sh -c "cd /work && $1"
}
as_root() {
    chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin DEBIAN_FRONTEND=noninteractive sh -c "$1" >"$base.log" 2>&1 ||
        { tail -20 "$base.log"; exit 1; }
}
seconds() { awk "BEGIN { printf \"%.1f s\", $(date +%s.%N) - $1 }"; }
drawn() { # FILE
    [[ $(head -c 4 "$root/work/$1" | tail -c 3) == PNG ]] || { echo "FAILED: $1 is no picture"; exit 1; }
    echo "    $1: $(stat -c %s "$root/work/$1") bytes"
}

for part in "${parts[@]}"; do
    new_root
    case $part in
    archive)
        cp "$packages"/tessera-*-linux-*.tar.gz "$root/work/"
        began=$(date +%s.%N)
        as_nobody 'tar -xzf tessera-*.tar.gz'
        unpacked=$(date +%s.%N)
        echo "archive: unpacked in $(seconds "$began"), $(du -sm "$root"/work/tessera-*/ | cut -f1) MB"
        as_nobody 'tessera-*/bin/tessera --quiet render /dicom -o abdomen.png --view left'
        echo "    first picture $(seconds "$unpacked") after that"
        drawn abdomen.png
        as_nobody 'tessera-*/bin/tessera --quiet render /dicom -o words.png --title Abdomen --scale-bar --size 256x256'
        drawn words.png
        # Without OpenGL and a display: refused with a reason, never ended by a library.
        as_nobody 'tessera-*/bin/tessera render /dicom -o gpu.png --engine gpu' 2>&1 | sed 's/^/    /' | cut -c1-200 || true
        as_nobody 'tessera-*/bin/tessera view' 2>&1 | sed 's/^/    /' | cut -c1-200 || true
        # Every module is loaded once: VTK, OpenImageIO, OpenVDB, libcurl.
        as_nobody 'T=$(echo /work/tessera-*/bin/tessera) && $T -q import /dicom a.zarr && $T -q export a.zarr a.vti &&
            $T -q export a.zarr a.tif && $T -q export a.zarr a.vdb && $T -q info a.vti >/dev/null && $T -q info a.vdb >/dev/null &&
            $T -q info a.tif --spacing 1,1,1 >/dev/null && $T -q mesh a.zarr a.ply --isosurface 300 &&
            $T -q preset bone --format paraview -o bone.json && $T -q render a.zarr -o mesh.png --mesh a.ply --size 128x128'
        as_nobody 'tessera-*/bin/tessera -q info https://localhost/none.zarr' 2>&1 | sed 's/^/    /' | cut -c1-200 || true
        drawn mesh.png
        ;;
    deb)
        cp "$packages"/tessera_*.deb "$packages"/tessera-window_*.deb "$root/work/"
        cp /etc/resolv.conf "$root/etc/resolv.conf"
        began=$(date +%s.%N)
        before=$(du -sm "$root" | cut -f1)
        as_root 'apt-get -q update && apt-get -q -y --no-install-recommends install /work/tessera_*.deb && apt-get clean'
        echo "deb: tessera installed in $(seconds "$began"), $(($(du -sm "$root" | cut -f1) - before)) MB with what it needs"
        if chroot "$root" dpkg-query -W libglfw3 libgl1 >/dev/null 2>&1; then echo "FAILED: a display was installed"; exit 1; fi
        began=$(date +%s.%N)
        as_nobody '/usr/bin/tessera --quiet render /dicom -o abdomen.png --view left'
        echo "    first picture in $(seconds "$began")"
        drawn abdomen.png
        as_nobody '/usr/bin/tessera view' 2>&1 | sed 's/^/    /' | cut -c1-200 || true
        as_root 'apt-get -q -y --no-install-recommends install /work/tessera-window_*.deb'
        as_nobody '/usr/bin/tessera view' 2>&1 | sed 's/^/    with tessera-window: /' | cut -c1-200 || true
        if ls "$packages"/python3-tessera_*.deb >/dev/null 2>&1; then
            cp "$packages"/python3-tessera_*.deb "$root/work/"
            as_root 'apt-get -q -y --no-install-recommends install /work/python3-tessera_*.deb'
            as_nobody 'python3 -c "import tessera; tessera.render(tessera.open(\"/dicom\")).save(\"python.png\")"'
            drawn python.png
        fi
        as_root 'apt-get -q -y purge tessera tessera-window && apt-get -q -y purge python3-tessera || true'
        left=$(find "$root/usr" -path '*tessera*' | head -3)
        [[ -z $left ]] || { echo "FAILED: removal leaves $left"; exit 1; }
        ;;
    esac
done
