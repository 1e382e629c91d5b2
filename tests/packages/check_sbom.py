#!/usr/bin/env python3
"""A list in SPDX 2.3 is well formed and agrees with the unpacked archive. check_sbom.py LIST.spdx.json FOLDER"""
import hashlib
import json
import re
import sys
from pathlib import Path

ID = re.compile(r"SPDXRef-[A-Za-z0-9.-]+$")
KNOWN = set("""AND OR NOASSERTION Apache-2.0 Artistic-2.0 BSD-2-Clause BSD-3-Clause BSL-1.0 CC0-1.0 curl FTL GPL-1.0-or-later
GPL-2.0-only GPL-2.0-or-later GPL-3.0-only GPL-3.0-or-later HPND IJG ISC LGPL-2.0-only LGPL-2.0-or-later LGPL-2.1-only
LGPL-2.1-or-later LGPL-3.0-only LGPL-3.0-or-later Libpng libtiff MIT MPL-1.1 MPL-2.0 OpenSSL PostgreSQL Unicode-DFS-2016 X11
Zlib""".split())
# Fields that the schema of SPDX 2.3 knows, of those that are written.
PACKAGE = set("""name SPDXID versionInfo supplier downloadLocation filesAnalyzed sourceInfo licenseConcluded licenseDeclared copyrightText
externalRefs homepage packageVerificationCode licenseInfoFromFiles primaryPackagePurpose""".split())
FILE = {"fileName", "SPDXID", "fileTypes", "checksums", "licenseConcluded", "copyrightText"}
found = []


def expect(holds, what):
    if not holds:
        found.append(what)


def main():
    text, folder = json.loads(Path(sys.argv[1]).read_text()), Path(sys.argv[2])
    expect(text["spdxVersion"] == "SPDX-2.3" and text["dataLicense"] == "CC0-1.0", "version and licence of the list")
    expect(text["SPDXID"] == "SPDXRef-DOCUMENT" and text["documentNamespace"].startswith("https://"), "the list's name")
    expect(re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", text["creationInfo"]["created"]), "time of the list")
    refs = {one["licenseId"] for one in text["hasExtractedLicensingInfos"]}
    for one in text["hasExtractedLicensingInfos"]:
        expect(one["licenseId"].startswith("LicenseRef-") and one["extractedText"].strip(), f"text of {one['licenseId']}")
    ids = ["SPDXRef-DOCUMENT"]
    for package in text["packages"]:
        ids.append(package["SPDXID"])
        for field in ("name", "versionInfo", "downloadLocation", "supplier", "licenseConcluded", "licenseDeclared", "copyrightText"):
            expect(package.get(field), f"{package['name']}: {field}")
        expect(set(package) <= PACKAGE, f"{package['name']}: fields {set(package) - PACKAGE}")
        unknown = set(package["licenseDeclared"].split()) - KNOWN - refs
        expect(not unknown, f"{package['name']}: licence {unknown}")
        expect(package["filesAnalyzed"] == ("packageVerificationCode" in package), f"{package['name']}: its files' code")
    listed = set()
    for file in text["files"]:
        ids.append(file["SPDXID"])
        path = folder / file["fileName"]
        listed.add(path.resolve())
        expect(set(file) == FILE, f"{path}: fields {set(file) ^ FILE}")
        sums = {one["algorithm"]: one["checksumValue"] for one in file["checksums"]}
        expect(path.is_file() and hashlib.sha256(path.read_bytes()).hexdigest() == sums["SHA256"], f"{path}: its sum")
        expect("SHA1" in sums, f"{path}: SHA1")
    expect(all(ID.match(one) for one in ids) and len(ids) == len(set(ids)), "names of elements")
    linked = set()
    for relation in text["relationships"]:
        ends = (relation["spdxElementId"], relation["relatedSpdxElement"])
        expect(all(end in ids for end in ends), f"relationship of {ends}")
        linked.add(ends[1])
    expect(set(ids) - linked == {"SPDXRef-DOCUMENT"}, f"relationships of {set(ids) - linked}")
    libraries = {path.resolve() for path in folder.rglob("*") if path.is_file() and (path.suffix == ".ttf" or path.read_bytes()[:4] == b"\x7fELF")}
    expect(libraries == listed, f"programs, libraries and fonts: {[str(p) for p in libraries ^ listed]}")
    licences = folder / "share/doc/tessera/third-party"
    for package in text["packages"]:
        if package["name"] != "tessera" and package["filesAnalyzed"]:
            expect((licences / f"{package['name']}.txt").is_file(), f"copyright of {package['name']}")
    print("\n".join(found) or f"SBOM: {len(text['packages'])} packages, {len(listed)} files")
    return 1 if found else 0


sys.exit(main())
