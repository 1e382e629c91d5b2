"""Which tests may reach a source: those of the programs that hold an object of it, in the order in which they are worth
running. Not by gcov: a build for it and a run of every test in it cost more than the tests that it would save
(README.md). What each program's tests take is learnt once and kept beside the build."""
import hashlib
import json
import os
import re
import subprocess
import sys
from pathlib import Path

CHEAP_SECONDS = 1.0  # tests that take less come before all others


class Reach:
    def __init__(self, copy):
        self.copy, self.learnt, self.includers = copy, {}, {}
        listed = subprocess.run(["ctest", "--test-dir", copy.build, "--show-only=json-v1"], check=True, env=copy.env,
                                capture_output=True, text=True).stdout
        programs = {Path(test["command"][0]).name for test in json.loads(listed)["tests"]
                    if any(word.startswith("--gtest_filter=") for word in test.get("command", ()))}
        self.objects = {p: {line for line in self.ninja("-t", "inputs", p) if line.endswith(".o")} for p in programs}

    def ninja(self, *arguments):
        return subprocess.run(["ninja", "-C", self.copy.build, *arguments], check=True, capture_output=True,
                              text=True).stdout.split("\n")

    def objects_with(self, file):
        """Objects that compile a file, or include it."""
        if not self.includers:
            places, of = {}, ""  # headers are found by links in the build folder
            for line in self.ninja("-t", "deps"):
                path = line.strip()
                if line.startswith("    "):
                    if path not in places:
                        places[path] = os.path.relpath(os.path.realpath(self.copy.build / path), self.copy.root)
                    self.includers.setdefault(places[path], set()).add(of)
                elif ":" in line:
                    of = line.split(":")[0]
        return self.includers.get(file, set())

    def sources(self, program):
        """Files below tests/ that a program is made of."""
        own = f"tests/CMakeFiles/{program}.dir/"
        return sorted(file for file, objects in self.includers.items() if file.startswith("tests/") and
                      any(of.startswith(own) for of in objects))

    def programs(self, file):
        """Test programs that hold a file, the nearest first: those whose tests include its header, then those that
        include most from its folder, then those that hold the fewest objects."""
        objects, folder = self.objects_with(file), os.path.dirname(file)

        def distance(program):
            names = [name for source in self.sources(program) if source.endswith(".cpp")
                     for name in re.findall(r'#include "(.+)"', (self.copy.root / source).read_text())]
            near = sum(os.path.dirname(name) == folder for name in names) / max(len(names), 1)
            return os.path.splitext(file)[0] + ".h" not in names, -near, len(self.objects[program]), program
        return sorted((p for p in self.objects if self.objects[p] & objects), key=distance)

    def learn(self, program):
        """Seconds of a program's tests that pass without a mutant."""
        if program in self.learnt:
            return
        state = hashlib.sha256(b"".join((self.copy.root / file).read_bytes() for file in self.sources(program))).hexdigest()
        path = self.copy.build / "learnt" / f"{program}.json"
        known = json.loads(path.read_text()) if path.exists() else {}
        if known.get("state") != state:
            if text := self.copy.make([program]):
                sys.exit(f"the sources do not build without a mutant:\n{text[-3000:]}")
            _, text = self.copy.call([str(self.copy.build / program), "--gtest_color=no"], 20 * self.copy.timeout)
            took = re.findall(r"^\[       OK \] (\S+?)(?:, where.*)? \((\d+) ms\)$", text, re.M)
            known = {"state": state, "seconds": {name: int(ms) / 1000 for name, ms in took}}
            path.parent.mkdir(exist_ok=True)
            path.write_text(json.dumps(known))
            print(f"learnt {program}: {len(took)} tests, {sum(known['seconds'].values()):.0f} s", flush=True)
        self.learnt[program] = known["seconds"]

    def tests(self, file, most):
        """Of the `most` nearest programs: (program, its tests, their seconds); the nearest one's first, and cheap ones
        before dear ones."""
        own, cheap, dear = [], [], []
        for program in self.programs(file)[:most]:
            self.learn(program)
            known = self.learnt[program]
            few = [name for name, seconds in known.items() if seconds < CHEAP_SECONDS]
            together = [(program, few, sum(known[name] for name in few))] if few else []
            alone = sorted(((program, [name], s) for name, s in known.items() if name not in few), key=lambda t: t[2])
            if not own:
                own = together + alone
            else:
                cheap, dear = cheap + together, dear + alone
        return own + cheap + sorted(dear, key=lambda test: test[2])
