# tests/packages/checks.sh: for the tests of packages. Sourced with `here` set; `work` is a new folder, removed at the end.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fail() {
    echo "FAILED: $1" >&2
    exit 1
}
# The time of the version, seconds.
epoch() { date -d "$(sed -n "s/^ -- .*>  //p" "$here/../../cmake/packages/debian/changelog" | head -1)" +%s; }
has() { command -v "$1" >/dev/null; }

# A phantom and a small DICOM series, drawn by a program in an empty environment. PROGRAM FOLDER
draws() {
    local program=$1 folder=$2 run picture
    [[ -d $folder/ball ]] || python3 "$here/small_dicom.py" "$folder/ball"
    run=(env -i "$program")
    (
        cd "$folder"
        "${run[@]}" --quiet phantom torso --size 48x40x60 -o torso.zarr --force
        "${run[@]}" --quiet render torso.zarr -o torso.png --size 64x64
        # The cache of imports needs a folder of the user's.
        "${run[@]}" --quiet import ball ball.zarr --force
        "${run[@]}" --quiet render ball.zarr -o ball.png --size 64x64
        "${run[@]}" --quiet render ball -o cached.png --size 64x64
        "${run[@]}" --quiet export ball.zarr ball.nii --force
        "${run[@]}" --quiet mesh ball.zarr ball.ply --isosurface 200 --force
    )
    for picture in torso ball cached; do
        [[ $(head -c 4 "$folder/$picture.png" | tail -c 3) == PNG ]] || fail "$picture.png is no picture"
        (($(stat -c %s "$folder/$picture.png") > 1000)) || fail "$picture.png shows nothing"
    done
}

# Documents, pages of the manual and completion. PREFIX
check_layout() {
    local prefix=$1 path
    for path in bin/tessera lib/tessera/tessera_importers.so share/man/man1/tessera.1.gz share/man/man1/tessera-render.1.gz \
        share/doc/tessera/README.md share/doc/tessera/docs/user-guide.md share/bash-completion/completions/tessera; do
        [[ -s $prefix/$path ]] || fail "$path is missing"
    done
    bash -n "$prefix/share/bash-completion/completions/tessera" || fail "completion of bash"
    if has man; then
        for path in "$prefix"/share/man/man1/*; do
            # groff names what it cannot set.
            MANWIDTH=80 MANROFFSEQ='' man --warnings -E UTF-8 -l -Tutf8 -Z "$path" 2>"$work/warned" >/dev/null
            [[ ! -s $work/warned ]] || fail "$path: $(<"$work/warned")"
        done
    fi
}

check_desktop() {
    local share=$1/share name=org.tessera.Tessera
    [[ -s $share/icons/hicolor/scalable/apps/$name.svg ]] || fail "no icon"
    if has desktop-file-validate; then desktop-file-validate "$share/applications/$name.desktop" || fail "desktop entry"; fi
    if has appstreamcli; then
        appstreamcli validate --no-net "$share/metainfo/$name.metainfo.xml" >/dev/null || fail "metainfo"
    fi
    if has update-mime-database; then
        cp -r "$share/mime" "$work/mime"
        update-mime-database "$work/mime" >"$work/mime.log" 2>&1 || fail "MIME types: $(<"$work/mime.log")"
        grep -q "application/x-nifti:\*.nii.gz" "$work/mime/globs" || fail "MIME types: no NIfTI"
    fi
}
