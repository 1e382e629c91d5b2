"""What run.py and sample.py share: a mutant, and the copy of the sources in which one is planted, built and tested.
The working tree is never touched."""
import fcntl
import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import processes
from processes import Limits

ROOT = Path(__file__).resolve().parents[2]
MEMORY_BYTES = 16 << 30  # of address space for a test program: a mutant may allocate without end,
FILE_BYTES = 4 << 30  # or write
IDLE_SECONDS, CLOCK_SECONDS = 120, 7200  # a command that waits for ever: without a processor, or at all


@dataclass
class Edit:
    """One replacement; `old` stands exactly once in `file`."""
    file: str
    old: list = field(default_factory=list)
    new: list = field(default_factory=list)


@dataclass
class Mutant:
    room: str
    name: str
    place: str  # file and line of the entry, for messages
    why: str = ""
    edits: list = field(default_factory=list)
    tests: list = field(default_factory=list)  # (program, gtest filter), nearest first


class Tested(NamedTuple):
    by: str  # who failed; "" where all passed
    text: str  # what they wrote
    seconds: float  # of processors


class ListedTest(NamedTuple):
    program: str
    name: str  # GoogleTest's
    command: list
    is_picture: bool
    in_gate: bool  # of pictures: `.ci/run` runs it


class Stale(Exception):
    """A mutant that no longer fits the sources, or is written wrongly."""


def planted(edit, text, place):
    """The file's text with the mutant in it."""
    old, new = "\n".join(edit.old), "\n".join(edit.new)
    if not old or old == new:
        raise Stale(f"{place}: expected an old and another new text for {edit.file}")
    if (count := text.count(old)) != 1:
        raise Stale(f"{place}: expected its old text once in {edit.file}, found it {count} times")
    return text.replace(old, new)


class Copy:
    """The copy of the sources in which mutants are planted, and its build."""

    # What cmake is told. A change that compiles with a warning is no mutant, because it would not be kept. Nor does a
    # build run test programs for the names of their tests: on a busy machine they may be too late.
    CONFIGURE = ("--preset", "release", "-DCMAKE_COMPILE_WARNING_AS_ERROR=ON",
                 "-DCMAKE_GTEST_DISCOVER_TESTS_DISCOVERY_MODE=PRE_TEST")
    BUILD = "release"  # folder of the build, in build/ of the copy

    def __init__(self, folder, jobs, timeout):
        self.root, self.build = folder, folder / "build" / self.BUILD
        self.jobs, self.timeout = jobs, timeout
        self.dirty = {}  # original text of files that hold a mutant
        self.env = dict(os.environ, CCACHE_BASEDIR=str(folder), CCACHE_NOHASHDIR="1", TMPDIR=str(folder / "build" / "tmp"))
        # Tests of real scans look beside the sources, where the copy has nothing.
        self.env.setdefault("TESSERA_TEST_DATA", str(ROOT.parent / "shared" / "data"))

    def update(self):
        """Makes the copy equal to the working tree; files that are equal keep their time."""
        mark = self.root / "build" / "lock"  # what is in a folder without it is not ours to remove
        if self.root.exists() and any(self.root.iterdir()) and not mark.exists():
            sys.exit(f"{self.root}: expected a new folder or the copy of an earlier run, found something else")
        self.build.mkdir(parents=True, exist_ok=True)
        self.lock = open(mark, "w")
        try:
            fcntl.flock(self.lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            sys.exit(f"another run works in {self.root}")
        listed = subprocess.run(["git", "-C", ROOT, "ls-files", "-co", "--exclude-standard", "-z"], check=True,
                                capture_output=True, text=True).stdout.split("\0")
        wanted = {name for name in listed if name and (ROOT / name).is_file()}
        for name in wanted:
            to, content = self.root / name, self.content(name)
            if not to.is_file() or to.read_bytes() != content:
                to.parent.mkdir(parents=True, exist_ok=True)
                to.write_bytes(content)
                shutil.copymode(ROOT / name, to)
        for path in list(self.root.rglob("*")):
            name = path.relative_to(self.root)
            if name.parts[0] != "build" and path.is_file() and str(name) not in wanted:
                path.unlink()
        if not (self.build / "build.ninja").exists():
            subprocess.run(["cmake", *self.CONFIGURE, "-DTESSERA_WITH_TESTS=ON"], check=True, cwd=self.root,
                           env=self.env, stdout=subprocess.DEVNULL)

    def content(self, name):
        """What a file of the copy holds."""
        return (ROOT / name).read_bytes()

    def plant(self, mutant):
        for edit in mutant.edits:
            path = self.root / edit.file
            text = path.read_text()
            self.dirty.setdefault(path, text)
            path.write_text(planted(edit, text, mutant.place))

    def restore(self):
        for path, text in self.dirty.items():
            path.write_text(text)
        self.dirty.clear()
        shutil.rmtree(self.env["TMPDIR"], ignore_errors=True)

    def make(self, targets):
        """Builds; returns what the compiler said where that fails."""
        done = processes.run(["ninja", "-C", self.build, "-j", self.jobs, *targets], self.root, self.env)
        return "" if done.status == 0 else done.text

    def listed_tests(self):
        """The tests of GoogleTest that ctest has."""
        pictures = subprocess.run(["bash", "-c", 'source .ci/tests.sh; echo "$one_a_feature|$one_store"'], check=True,
                                  cwd=self.root, capture_output=True, text=True).stdout.strip()
        listed = subprocess.run(["ctest", "--test-dir", self.build, "--show-only=json-v1"], check=True, env=self.env,
                                capture_output=True, text=True).stdout
        for test in json.loads(listed)["tests"]:
            command = test.get("command", [""])
            names = [word.split("=", 1)[1] for word in command if word.startswith("--gtest_filter=")]
            labels = [kind["value"] for kind in test.get("properties", ()) if kind["name"] == "LABELS"]
            if names:
                yield ListedTest(Path(command[0]).name, names[0], command, labels == [["image"]],
                                 bool(re.search(pictures, test["name"])))

    def call(self, command, timeout=None, env=None):
        """Runs a command, which hangs after `timeout` seconds of a processor, or where it takes none any more."""
        timeout = timeout or self.timeout
        os.makedirs(self.env["TMPDIR"], exist_ok=True)
        return processes.run(command, self.build, env or self.env,
                             Limits(CLOCK_SECONDS, IDLE_SECONDS, timeout, MEMORY_BYTES, FILE_BYTES))

    def run_tests(self, program, tests, timeout=None):
        """Runs tests until one fails."""
        code, text, seconds = self.call([self.build / program, f"--gtest_filter={tests}", "--gtest_fail_fast",
                                         "--gtest_color=no"], timeout)
        if code == 0:
            return Tested("", text, seconds)
        return Tested(self.failed(program, code, text), text, seconds)

    @staticmethod
    def failed(program, code, text):
        """Who failed, by what tests wrote."""
        failed = re.search(r"\[  FAILED  \] ([\w/.]+)", text)
        begun = (re.findall(r"\[ RUN      \] (\S+)", text) or [program])[-1]
        ends = f"{begun}: hangs" if code is None else f"{begun}: ends with {code}"
        return failed.group(1) if failed else ends
