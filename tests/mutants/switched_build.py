"""A build of all faults of a sample behind switches (switching.py), what tests of it reach, and a test with some of them."""
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import processes
from planting import ROOT, Copy, Tested
from switching import MANNERS, switched

MOST = 4096  # faults: faults.c
ERROR = re.compile(r"^(\S+?):(\d+):\d+: (?:fatal )?error: ", re.M)
SAID = re.compile(r"^(\S+?):(\d+):\d+: ", re.M)


class SwitchedBuild(Copy):
    """The copy with faults, {number: mutant as sample.py draws it}."""

    def __init__(self, folder, jobs, timeout):
        super().__init__(folder, jobs, timeout)
        self.set_faults([])
        self.library = folder / "build" / "libfaults.so"
        self.CONFIGURE = ("--preset", "release", f"-DCMAKE_CXX_STANDARD_LIBRARIES={self.library}",
                          "-DCMAKE_GTEST_DISCOVER_TESTS_DISCOVERY_MODE=PRE_TEST")
        self.kept = folder / "build" / "learnt.json"
        self.stores, self.one = self.build / "test-stores", threading.Lock()
        self.planted = None  # (file, line, text) of a fault without a switch

    def set_faults(self, chosen):
        """`chosen`: (mutant, the number of its switch's manner)."""
        self.faults = {n: mutant for n, (mutant, _) in enumerate(chosen)}
        self.manners = {n: manner for n, (_, manner) in enumerate(chosen)}
        self.parts = {}  # by file, the lines of its faults

    def content(self, name):
        text = super().content(name)
        own = [(n, m["line"], m["operator"], m["after"], MANNERS[self.manners[n]]) for n, m in self.faults.items()
               if m["file"] == name and self.manners[n] < len(MANNERS)]
        if self.planted and self.planted[0] == name:
            lines = text.decode().split("\n")
            lines[self.planted[1] - 1] = self.planted[2]
            text = "\n".join(lines).encode()
        elif not own:
            return text
        new, self.parts[name] = switched(text.decode(), own)
        for n, *_ in own:
            if n not in self.parts[name]:  # no place in this manner
                self.manners[n] += 1
                return self.content(name)
        return new.encode()

    def alone(self, tests):
        """Faults that have no switch, and those of constexpr functions that run nowhere: they may have run in the compiler."""
        reached = set().union(*(of["reached"] for of in tests.values()))
        return {n for n, manner in self.manners.items() if manner >= len(MANNERS) or
                (MANNERS[manner] == "constant" and n not in reached)}

    def make_all(self):
        """Builds; faults that do not compile are tried in their next manner."""
        for _ in range(3 * len(MANNERS)):
            self.update()
            done = processes.run(["ninja", "-C", self.build, "-j", self.jobs, "-k", 0], self.root, self.env)
            if done.status == 0:
                return
            if not (wrong := self.wrong(done.text)):
                sys.exit(f"the sources do not build with faults behind switches:\n{done.text[-3000:]}")
            for n in wrong:
                self.manners[n] += 1
            print(f"{len(wrong)} switches do not compile: tried in another manner", flush=True)
        sys.exit("the sources do not build with faults behind switches")

    def configure(self):
        """Makes the copy, without faults, and the library that has the switches."""
        if not self.library.exists():
            self.library.parent.mkdir(parents=True, exist_ok=True)
            (self.root / "build" / "lock").touch()
            subprocess.run(["gcc", "-O2", "-shared", "-fPIC", Path(__file__).with_name("faults.c"), "-o", self.library], check=True)
        self.update()

    def wrong(self, text):
        """Faults that a compiler's messages are about: at an error's line, else at another that its message names, else
        all of that file."""
        found = set()
        for block in re.split(r"(?m)^(?=FAILED: )", text):
            places = [self.place(m) for m in ERROR.finditer(block)]
            for at, others in ((places, False), ([self.place(m) for m in SAID.finditer(block)], True)):
                named = {n for file, line in at for n, (a, b) in self.parts.get(file, {}).items() if a <= line <= b}
                if others and not named:
                    named = {n for file, _ in at for n in self.parts.get(file, {})}
                if named:
                    found |= named
                    break
        return {n for n in found if self.manners[n] < len(MANNERS)}

    def place(self, match):
        path = os.path.realpath(self.build / match.group(1))
        return os.path.relpath(path, self.root), int(match.group(2))

    def prepare(self):
        """Builds, makes the stores of tests, and learns what tests reach: {name: {program, command, seconds, reached}}."""
        self.make_all()
        pristine = self.build / "pristine-stores"
        if not pristine.exists():
            for folder in (self.stores, pristine):
                if self.call([str(self.build / "prepare_test_stores"), str(folder)], 40 * self.timeout)[0] != 0:
                    sys.exit("prepare_test_stores fails without a fault")
        self.state = self.of_stores()
        told = json.dumps([self.faults, self.manners, sorted(self.sums().items())])
        state = hashlib.sha256(told.encode()).hexdigest()
        known = json.loads(self.kept.read_text()) if self.kept.exists() else {}
        if known.get("state") != state:
            tests = self.tests()
            with ThreadPoolExecutor(self.jobs) as threads:
                found = dict(zip(tests, threads.map(lambda test: self.learn(*test), tests.items())))
            known = {"state": state, "tests": {name: of for name, of in found.items() if of}}
            self.kept.write_text(json.dumps(known))
            failed = sorted(set(tests) - set(known["tests"]))
            print(f"learnt {len(known['tests'])} tests" + (f"; fail without a fault: {', '.join(failed)}" if failed else ""), flush=True)
        return known["tests"]

    def sums(self):
        """Sums of all programs and modules of the build."""
        return {str(path.relative_to(self.build)): hashlib.sha256(path.read_bytes()).hexdigest()
                for path in self.build.rglob("*") if path.is_file() and os.access(path, os.X_OK) and "CMakeFiles" not in path.parts
                and not path.is_relative_to(self.stores) and "pristine-stores" not in path.parts}

    def tests(self):
        """All but pictures of engines, of which those of `.ci/run`: {name: (program, command)}."""
        return {f"{test.program} {test.name}": (test.program, test.command) for test in self.listed_tests()
                if test.in_gate or not (test.is_picture and test.program.startswith("render_"))}

    def learn(self, name, of):
        """What a test takes and reaches; None where it does not pass."""
        program, command = of
        file = self.root / "build" / "reached" / hashlib.sha256(name.encode()).hexdigest()[:16]
        file.parent.mkdir(exist_ok=True)
        file.write_bytes(bytes(MOST))
        done = self.call(command, 10 * self.timeout, dict(self.env, TESSERA_FAULTS_REACHED=str(file)))
        reached = [n for n, byte in enumerate(file.read_bytes()) if byte]
        file.unlink()
        return None if done.status != 0 else {"program": program, "command": command, "seconds": round(done.seconds, 2),
                                              "reached": reached}

    def run(self, program, names, faults, timeout):
        """Runs tests of a program with faults until one fails."""
        with tempfile.TemporaryDirectory(prefix="t-") as folder:  # a short name, as tests have it otherwise
            env = dict(self.env, TESSERA_FAULTS=",".join(map(str, sorted(faults))), TMPDIR=folder)
            code, text, seconds = self.call([self.build / program, f"--gtest_filter={':'.join(names)}", "--gtest_fail_fast",
                                             "--gtest_color=no"], timeout, env)
        self.mend_stores()
        return Tested("" if code == 0 else self.failed(program, code, text), text, seconds)

    def of_stores(self):
        return {str(path.relative_to(self.stores)): (path.stat().st_size, path.stat().st_mtime_ns)
                for path in self.stores.rglob("*") if path.is_file()}

    def mend_stores(self):
        """A fault may write where tests only read."""
        with self.one:
            try:
                if self.of_stores() == self.state:
                    return
            except OSError:
                pass
            shutil.rmtree(self.stores)
            shutil.copytree(self.build / "pristine-stores", self.stores)
            self.state = self.of_stores()
