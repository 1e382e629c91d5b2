"""Every link of the documents leads somewhere: to a file that is there, and to a heading that it has.

links.py [ROOT]: prints those that do not, one a line."""

import pathlib
import re
import sys

ROOT = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else __file__).resolve()
ROOT = ROOT if ROOT.is_dir() else ROOT.parents[2]
LEFT_OUT = {"build", ".git", "shared"}


def without_code(text):
    return re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)


def anchors(page):
    """The names that GitHub gives to a page's headings."""
    names = set()
    for heading in re.findall(r"^#+ (.*)$", without_code(page.read_text(encoding="utf-8")), re.MULTILINE):
        words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        names.add(re.sub(r"[^\w\- ]", "", words).replace(" ", "-"))
    return names


def faults(page):
    for target in re.findall(r"\]\(([^)\s]+)\)", without_code(page.read_text(encoding="utf-8"))):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        if not file.exists():
            yield f"{target}: expected a file of the tree, found none"
        elif anchor and file.suffix == ".md" and anchor not in anchors(file):
            yield f"{target}: expected a heading of that name, found none"


pages = [page for page in sorted(ROOT.rglob("*.md")) if not LEFT_OUT & set(page.relative_to(ROOT).parts)]
found = [f"{page.relative_to(ROOT)}: {fault}" for page in pages for fault in faults(page)]
assert len(pages) > 20, f"{ROOT}: expected the project's pages, found {len(pages)}"
print("\n".join(found))
sys.exit(bool(found))
