"""Whether a source with a fault compiles without a warning, alone: a fault that does not is none."""
import json
import os
import re
import shlex
import tempfile
from pathlib import Path

import processes


class Compiler:
    """The compiler of a copy's sources, each with the command of its own."""

    def __init__(self, copy):
        self.copy, folder = copy, copy.root / "build" / "apart"
        configure = ["cmake", "--preset", "release", "-B", folder, "-DTESSERA_UNITY=OFF", "-DTESSERA_WITH_TESTS=OFF",
                     "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON"]
        if (done := processes.run(configure, copy.root, copy.env)).status != 0:
            raise SystemExit(f"the sources cannot be configured:\n{done.text[-3000:]}")
        entries = json.loads((folder / "compile_commands.json").read_text())
        self.commands = {os.path.relpath(entry["file"], copy.root): entry for entry in entries}
        self.includers = {}  # by file
        for path in copy.root.rglob("*.[ch]*"):
            file = str(path.relative_to(copy.root))
            if path.suffix in (".cpp", ".h") and not file.startswith("build/"):
                for included in re.findall(r'#include "(.+)"', path.read_text()):
                    self.includers.setdefault(included, set()).add(file)

    def source_of(self, file):
        """A source that compiles a file: itself, or the nearest by includes, of these by name."""
        ring, seen = {file}, set()
        while ring:
            if found := ring & set(self.commands):
                return max(found, key=lambda source: (len(os.path.commonprefix([source, file])), source))
            seen |= ring
            ring = set().union(*(self.includers.get(of, set()) for of in ring)) - seen
        return None

    def error(self, file, text):
        """The first error or warning of a file's text; "" where there is none."""
        if (source := self.source_of(file)) is None:
            return "no source includes it"
        entry = self.commands[source]
        words, with_output = [], shlex.split(entry["command"])
        while with_output:
            word = with_output.pop(0)
            if word == "-o":
                with_output.pop(0)
            elif word not in ("-c", entry["file"]):
                words.append(word)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / file
            path.parent.mkdir(parents=True)
            path.write_text(text)
            compiled = path if source == file else entry["file"]
            command = [words[0], f"-I{folder}", *words[1:], "-O0", "-fsyntax-only", "-Werror", compiled]
            done = processes.run(command, entry["directory"], self.copy.env)
        said = re.search(r"^.*error: .*$", done.text, re.M)
        return "" if done.status == 0 else said.group(0)[-200:] if said else done.text[-200:] or "no compiler"
