#!/usr/bin/env python3
"""Writes the list of all software in an unpacked archive, in SPDX 2.3: what bundle.py copied, by dpkg's database, and what is
compiled into the program.

    sbom.py FOLDER VERSION OUT.spdx.json

The licence that a package declares is that of "Files: *" of Debian's copyright file; the file as a whole is in the archive.
SOURCE_DATE_EPOCH is the time of the list."""
import hashlib
import json
import os
import re
import subprocess
import sys
import time
from pathlib import Path

# Headers and static libraries of others that the program's own files hold.
COMPILED_IN = ["libcli11-dev", "libglm-dev", "libimgui-dev", "libimath-dev", "libopenvdb-dev", "libtbb-dev", "nlohmann-json3-dev"]

# Debian's short names where SPDX has another one.
SPDX_NAMES = {
    "apache-2": "Apache-2.0", "apache-2.0": "Apache-2.0", "artistic-2.0": "Artistic-2.0", "bsd-2-clause": "BSD-2-Clause",
    "bsd-3-clause": "BSD-3-Clause", "bsl-1.0": "BSL-1.0", "cc0": "CC0-1.0", "cc0-1.0": "CC0-1.0", "curl": "curl",
    "expat": "MIT", "mit": "MIT", "ftl": "FTL", "gpl-1+": "GPL-1.0-or-later", "gpl-2": "GPL-2.0-only", "gpl-2.0": "GPL-2.0-only",
    "gpl-2+": "GPL-2.0-or-later", "gpl-2.0+": "GPL-2.0-or-later", "gpl-3": "GPL-3.0-only", "gpl-3+": "GPL-3.0-or-later",
    "gpl-3.0+": "GPL-3.0-or-later", "hpnd": "HPND", "ijg": "IJG", "isc": "ISC", "lgpl-2": "LGPL-2.0-only",
    "lgpl-2+": "LGPL-2.0-or-later", "lgpl-2.0+": "LGPL-2.0-or-later", "lgpl-2.1": "LGPL-2.1-only",
    "lgpl-2.1+": "LGPL-2.1-or-later", "lgpl-3": "LGPL-3.0-only", "lgpl-3+": "LGPL-3.0-or-later", "lgpl-3.0+": "LGPL-3.0-or-later",
    "libpng": "Libpng", "libtiff": "libtiff", "mpl-1.1": "MPL-1.1", "mpl-2.0": "MPL-2.0", "openssl": "OpenSSL",
    "postgresql": "PostgreSQL", "unicode": "Unicode-DFS-2016", "x11": "X11", "zlib": "Zlib", "zlib/libpng": "Zlib",
}


def paragraphs(text):
    """Fields of a machine-readable copyright file, a dictionary a paragraph."""
    for part in re.split(r"\n\s*\n", text):
        fields, name = {}, None
        for line in part.splitlines():
            if line[:1] in (" ", "\t"):
                if name:
                    fields[name] += "\n" + line[1:]
            elif match := re.match(r"([A-Za-z-]+):\s*(.*)", line):
                name = match[1].lower()
                fields[name] = match[2]
        if fields:
            yield fields


class Licences:
    """Expressions of SPDX for Debian's short names; what SPDX does not know keeps its text."""

    def __init__(self):
        self.extracted = {}

    def expression(self, package, short, texts):
        """None where it cannot be said."""
        words = []
        for word in re.split(r"\s+(and|or)\s+", short.replace(",", " ").strip(), flags=re.I):
            word = word.strip()
            if word.lower() in ("and", "or"):
                words.append(word.upper())
                continue
            known = SPDX_NAMES.get(re.sub(r"\.0(\+?)$", r".0\1", word.lower()))
            if not known:
                text = texts.get(word, "").strip()
                if not word or " " in word or not text:
                    return None
                known = "LicenseRef-" + re.sub(r"[^A-Za-z0-9.-]", "-", f"{package}-{word}")
                self.extracted[known] = {"licenseId": known, "name": word, "extractedText": text}
            words.append(known)
        mixed = "AND" in words and "OR" in words
        return None if mixed else " ".join(words)

    def of(self, package):
        """(declared licence, copyright) of a Debian package; where the file is not for machines, the file itself."""
        text = Path(f"/usr/share/doc/{package}/copyright").read_text(errors="replace")
        parts = list(paragraphs(text))
        texts = {}
        for part in parts:
            short, _, body = part.get("license", "").partition("\n")
            texts.setdefault(short.strip(), body or "")
        declared, holders = None, "NOASSERTION"
        for part in parts:
            if part.get("files", "").split()[:1] == ["*"]:
                declared = self.expression(package, part.get("license", "").partition("\n")[0], texts)
                holders = " ".join(part.get("copyright", "").split()) or holders
        if not declared:
            declared = f"LicenseRef-{package}"
            self.extracted[declared] = {"licenseId": declared, "name": f"copyright of {package}", "extractedText": text}
        return declared, holders


def dpkg_fields(packages):
    form = "\t".join("${%s}" % f for f in ("Package", "Version", "source:Package", "source:Version", "Homepage",
                                            "Architecture")) + "\n"
    listed = subprocess.run(["dpkg-query", "-W", "-f", form, *packages], capture_output=True, text=True, check=True).stdout
    return [line.split("\t") for line in listed.splitlines()]


def spdx_id(*names):
    return "SPDXRef-" + re.sub(r"[^A-Za-z0-9.-]", "-", "-".join(names))


def file_entry(folder, path):
    data = (folder / path).read_bytes()
    return {"fileName": f"./{path}", "SPDXID": spdx_id("File", path), "fileTypes": ["OTHER" if path.endswith(".ttf") else "BINARY"],
            "checksums": [{"algorithm": "SHA1", "checksumValue": hashlib.sha1(data).hexdigest()},
                          {"algorithm": "SHA256", "checksumValue": hashlib.sha256(data).hexdigest()}],
            "licenseConcluded": "NOASSERTION", "copyrightText": "NOASSERTION"}


def verification_code(files):
    """Of a package: SHA1 of the sorted SHA1 of its files (SPDX 2.3, 7.9)."""
    sums = sorted(f["checksums"][0]["checksumValue"] for f in files)
    return {"packageVerificationCodeValue": hashlib.sha1("".join(sums).encode()).hexdigest()}


def package_entry(fields, licences, files):
    name, version, source, source_version, homepage, architecture = fields
    declared, holders = licences.of(name)
    entry = {"name": name, "SPDXID": spdx_id("Package", name), "versionInfo": version,
             "supplier": "Organization: Debian",
             "downloadLocation": f"https://snapshot.debian.org/package/{source}/{source_version}/",
             "filesAnalyzed": bool(files), "sourceInfo": f"Debian source package {source} {source_version}",
             "licenseConcluded": "NOASSERTION", "licenseDeclared": declared, "copyrightText": holders,
             "externalRefs": [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl",
                               "referenceLocator": f"pkg:deb/debian/{name}@{version.replace('+', '%2B').replace(':', '%3A')}?arch={architecture}"}]}
    if homepage:
        entry["homepage"] = homepage
    if files:
        entry["packageVerificationCode"] = verification_code(files)
        entry["licenseInfoFromFiles"] = ["NOASSERTION"]
    return entry


def relation(element, kind, other):
    return {"spdxElementId": element, "relationshipType": kind, "relatedSpdxElement": other}


def document(folder, version):
    licences = Licences()
    rows = [line.split("\t") for line in (folder / "share/doc/tessera/third-party/libraries.txt").read_text().splitlines()]
    files_of = {}
    for path, package in rows:
        files_of.setdefault(package, []).append(file_entry(folder, path))
    own = [file_entry(folder, str(p.relative_to(folder)))
           for p in [*sorted((folder / "bin").iterdir()), *sorted((folder / "lib/tessera").glob("*.so"))]]
    program = {"name": "tessera", "SPDXID": "SPDXRef-Package-tessera", "versionInfo": version,
               "supplier": "Organization: Tessera maintainers", "downloadLocation": "NOASSERTION", "filesAnalyzed": True,
               "packageVerificationCode": verification_code(own), "licenseInfoFromFiles": ["NOASSERTION"],
               "licenseConcluded": "Apache-2.0", "licenseDeclared": "Apache-2.0", "copyrightText": "Tessera maintainers",
               "primaryPackagePurpose": "APPLICATION"}
    packages, files = [program], list(own)
    relations = [relation("SPDXRef-DOCUMENT", "DESCRIBES", program["SPDXID"])]
    relations += [relation(program["SPDXID"], "CONTAINS", f["SPDXID"]) for f in own]
    names = {package.split(":")[0]: package for package in files_of}
    for fields in sorted(dpkg_fields(sorted(files_of))):
        held = files_of[names[fields[0]]]
        packages.append(package_entry(fields, licences, held))
        files += held
        links = any(f["fileTypes"] == ["BINARY"] for f in held)
        relations.append(relation(program["SPDXID"], "DYNAMIC_LINK" if links else "CONTAINS", packages[-1]["SPDXID"]))
        relations += [relation(packages[-1]["SPDXID"], "CONTAINS", f["SPDXID"]) for f in held]
    for fields in sorted(dpkg_fields(COMPILED_IN)):
        packages.append(package_entry(fields, licences, []))
        relations.append(relation(program["SPDXID"], "STATIC_LINK", packages[-1]["SPDXID"]))
    name = f"tessera-{version}"
    digest = hashlib.sha256("".join(f["checksums"][1]["checksumValue"] for f in files).encode()).hexdigest()
    created = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(int(os.environ["SOURCE_DATE_EPOCH"])))
    return {"spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT", "name": name,
            "documentNamespace": f"https://tessera.invalid/spdx/{name}-{digest[:32]}",
            "creationInfo": {"created": created, "creators": ["Organization: Tessera maintainers", "Tool: sbom.py-1"]},
            "packages": packages, "files": files, "relationships": relations,
            "hasExtractedLicensingInfos": [licences.extracted[k] for k in sorted(licences.extracted)]}


def main():
    folder, version, out = Path(sys.argv[1]).resolve(), sys.argv[2], Path(sys.argv[3])
    out.write_text(json.dumps(document(folder, version), indent=1) + "\n")


if __name__ == "__main__":
    main()
