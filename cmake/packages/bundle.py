#!/usr/bin/env python3
"""Copies what an unpacked archive needs from the system into it: libraries, the texts of their licences, and the list of all of
them in SPDX.

    bundle.py FOLDER        FOLDER holds bin/ and lib/tessera/, as installed

Libraries go to lib/. Those that drivers of graphics load as well go to lib/fallback/: the program takes the system's in place of
them, so that a driver never meets one that is older than it needs. Libraries of glibc and drivers stay the system's."""
import re
import shutil
import subprocess
import sys
from pathlib import Path

# For words on pictures, where the system has no font.
FONT = Path("/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf")
# Of the system always: glibc, of which it takes 2.36 and newer.
GLIBC = re.compile(r"(ld-linux.*|lib(c|m|dl|rt|pthread|resolv|mvec|util))\.so")
# Of the system where it has them: what drivers and servers of displays share with programs.
FALLBACK = re.compile(r"lib(stdc\+\+|gcc_s|X\w*|X11-xcb|xcb[\w-]*|GL\w*|EGL|OpenGL|OpenCL|drm\w*|va|va-\w+|vdpau|z|zstd|lzma"
                      r"|expat|elf|dw|ffi|xml2|bsd|md|udev|icu\w+)\.so")


def needed_by(file):
    """Libraries of a program or library, as the loader finds them here: name -> file."""
    listed = subprocess.run(["ldd", file], capture_output=True, text=True, check=True).stdout
    missing = re.findall(r"^\s*(\S+) => not found", listed, re.M)
    if missing:
        sys.exit(f"{file}: expected its libraries, found {', '.join(missing)} missing")
    return dict(re.findall(r"^\s*(\S+) => (/\S+)", listed, re.M))


def libraries(folder):
    """All that the program and its modules load, without glibc."""
    found = {}
    for file in [*sorted((folder / "bin").iterdir()), *sorted((folder / "lib/tessera").glob("*.so"))]:
        found.update(needed_by(file))
    return {name: Path(path).resolve() for name, path in sorted(found.items()) if not GLIBC.match(name)}


def packages_of(files):
    """Debian's package of each file: file -> package. One question for all of them."""
    spellings = {}  # the database knows /lib/... for some of what lies in /usr/lib/...
    for file in files:
        spellings[str(file)] = file
        if str(file).startswith("/usr/"):
            spellings[str(file)[4:]] = file
    listed = subprocess.run(["dpkg-query", "-S", *spellings], capture_output=True, text=True).stdout
    owners = {}
    for line in listed.splitlines():
        package, _, path = line.partition(": ")
        if path in spellings:
            owners[spellings[path]] = package.split(",")[0]
    for file in files:
        if file not in owners:
            sys.exit(f"{file}: expected a file of a Debian package, found none that owns it")
    return owners


def copy_libraries(folder, found):
    for name, source in found.items():
        target = folder / ("lib/fallback" if FALLBACK.match(name) else "lib") / name
        target.parent.mkdir(exist_ok=True)
        shutil.copyfile(source, target)
        target.chmod(0o644)


def copy_font(folder):
    target = folder / "share/tessera/fonts"
    target.mkdir(parents=True)
    shutil.copyfile(FONT, target / FONT.name)


def copy_licences(folder, packages):
    """copyright files as Debian has them, and the licences that these refer to."""
    target = folder / "share/doc/tessera/third-party"
    target.mkdir(parents=True)
    texts = set()
    for package in packages:
        name = package.split(":")[0]
        text = Path(f"/usr/share/doc/{name}/copyright").read_text(errors="replace")
        (target / f"{name}.txt").write_text(text)
        texts.update(re.findall(r"/usr/share/common-licenses/([A-Za-z0-9.-]*[A-Za-z0-9])", text))
    (target / "common-licenses").mkdir()
    for name in sorted(texts):
        source = Path("/usr/share/common-licenses") / name
        if source.is_file():
            shutil.copyfile(source, target / "common-licenses" / name)


def main():
    folder = Path(sys.argv[1]).resolve()
    found = libraries(folder)
    owners = packages_of({*found.values(), FONT})
    copy_libraries(folder, found)
    copy_font(folder)
    copy_licences(folder, sorted(set(owners.values())))
    with open(folder / "share/doc/tessera/third-party/libraries.txt", "w") as table:
        for name, source in found.items():
            table.write(f"{'lib/fallback' if FALLBACK.match(name) else 'lib'}/{name}\t{owners[source]}\n")
        table.write(f"share/tessera/fonts/{FONT.name}\t{owners[FONT]}\n")


if __name__ == "__main__":
    main()
