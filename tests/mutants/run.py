#!/usr/bin/env python3
"""Plants the mutants of this folder one at a time, builds, runs the nearest tests first and says which of them
caught it. README.md beside this file tells how a mutant is written. The working tree is never touched: all of it
happens in a copy (--build), which is brought up to date at every start and kept, with its build, between runs.
Exit status: 0 where all were caught, 1 where some survived or did not build, 2 where a mutant is stale."""
import argparse
import fnmatch
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import time
from pathlib import Path

import processes
from planting import ROOT, Copy, Edit, Mutant, Stale, planted

KEYS = ("why", "in", "test", "before")


def parse_room(path):
    """The mutants of one file, and the commands that must have run before its tests."""
    mutants, before = [], []
    for number, line in enumerate(path.read_text().splitlines(), 1):
        place = f"{path.name}:{number}"
        if line.startswith("= "):
            mutants.append(Mutant(path.stem, line[2:].strip(), place))
        elif line.startswith(("- ", "+ ")) or line in ("-", "+"):
            if not mutants or not mutants[-1].edits:
                raise Stale(f"{place}: text before an 'in:' line")
            edit = mutants[-1].edits[-1]
            (edit.old if line[0] == "-" else edit.new).append(line[2:])
        elif line.strip() and not line.startswith("#"):
            key, _, value = line.partition(":")
            value = value.strip()
            if key not in KEYS or not value or (key == "before") == bool(mutants):
                raise Stale(f"{place}: expected '= NAME', 'why:', 'in:', '- ', '+ ' or 'test:', found '{line}'")
            if key == "before":
                before.append(shlex.split(value))
            elif key == "why":
                mutants[-1].why += (" " if mutants[-1].why else "") + value
            elif key == "in":
                mutants[-1].edits.append(Edit(value))
            else:
                program, _, tests = value.partition(" ")
                mutants[-1].tests.append((program, tests.strip() or "*"))
    return mutants, before


def read_mutants():
    mutants, before = [], {}
    for path in sorted(Path(__file__).resolve().parent.glob("*.txt")):
        found, before[path.stem] = parse_room(path)
        mutants += found
    return mutants, before


def known_tests():
    """Names of all GoogleTest cases in the sources, and of all test programs."""
    names, programs = set(), set()
    for path in (ROOT / "tests").rglob("*.cpp"):
        for kind, suite, name in re.findall(r"\bTEST(_F|_P)?\(\s*(\w+),\s*(\w+)\s*\)", path.read_text()):
            names.add(f"{suite}.{name}")
            if kind == "_P":
                names.add(f"all/{suite}.{name}/0")
    for path in (ROOT / "tests").rglob("CMakeLists.txt"):
        programs |= set(re.findall(r"(?:tessera_add_\w*test|add_executable)\(\s*(\w+)", path.read_text()))
    return names, programs


def check(mutants):
    """Every problem of the mutants, as lines of text."""
    problems, seen = [], set()
    names, programs = known_tests()
    for m in mutants:
        if m.name in seen:
            problems.append(f"{m.place}: a second mutant {m.name}")
        seen.add(m.name)
        if not (m.why and m.edits and m.tests):
            problems.append(f"{m.place}: {m.name} lacks 'why:', 'in:' or 'test:'")
        texts = {}
        for edit in m.edits:
            try:
                text = texts.get(edit.file) or (ROOT / edit.file).read_text()
                texts[edit.file] = planted(edit, text, f"{m.place} {m.name}")
            except OSError:
                problems.append(f"{m.place} {m.name}: no file {edit.file}")
            except Stale as stale:
                problems.append(str(stale))
        for program, tests in m.tests:
            if program not in programs:
                problems.append(f"{m.place} {m.name}: no test program {program}")
            for part in tests.split(":"):
                if not any(fnmatch.fnmatchcase(name, part) for name in names):
                    problems.append(f"{m.place} {m.name}: no test is called {part}")
    return problems


class Bench(Copy):
    """A copy that knows what tests cost without a mutant."""

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.patience = {}  # seconds for tests whose time without a mutant is known

    def test(self, program, tests):
        """Runs tests with as much patience as they need; returns who failed, or "" where all passed."""
        return self.run_tests(program, tests, self.patience.get((program, tests))).by

    def learn(self, program, filters):
        """Runs the tests of all filters once, without a mutant; learns how long those of each take."""
        done = self.run_tests(program, ":".join(filters), 10 * self.timeout)
        if done.by:
            sys.exit(f"{done.by} fails without a mutant")
        taken = {name: int(ms) / 1000 for name, ms in re.findall(r"\[  (?:     OK|SKIPPED) \] (\S+) \((\d+) ms\)", done.text)}
        for tests in filters:
            parts = tests.split(":")
            seconds = [s for name, s in taken.items() if any(fnmatch.fnmatchcase(name, part) for part in parts)]
            if not seconds:
                sys.exit(f"{program} has no test {tests}")
            self.patience[program, tests] = min(self.timeout, 30 + 10 * sum(seconds))

    def gate(self):
        """Filters of the tests that .ci/run runs, by program."""
        filters = {}
        for test in self.listed_tests():
            if test.in_gate or not test.is_picture:
                filters.setdefault(test.program, []).append(test.name)
        return {program: ":".join(names) for program, names in filters.items()}

    def all_tests(self):
        """Builds everything and runs ctest; returns who failed."""
        if self.make(["all"]):
            return "the build of everything"
        done = subprocess.run(["ctest", "--test-dir", self.build, "-j", str(self.jobs), "--stop-on-failure"],
                              env=self.env, capture_output=True, text=True)
        shutil.rmtree(self.build / "test-stores", ignore_errors=True)  # may have been made by the mutant
        failed = re.search(r"^\s*\d+ - (\S+) \((\w+)", done.stdout.split("tests FAILED")[-1], re.M)
        return "" if done.returncode == 0 else failed.group(1) if failed else "ctest"


def judge(copy, mutant, gate, nearest, everything):
    """Plants one mutant; returns the verdict and who gave it. `gate`: Bench.gate(), or none."""
    try:
        copy.plant(mutant)
        programs = list(dict.fromkeys(program for program, _ in mutant.tests))
        if text := copy.make(programs):
            error = re.search(r"^.*error:.*$", text, re.M)
            return "no build", error.group(0) if error else text[-200:]
        if gate is not None:
            for program in programs:
                if program in gate and (by := copy.test(program, gate[program])):
                    return "caught", by
            return "survived", "the gate"
        wide = [(program, "*") for program in programs if (program, "*") not in mutant.tests and not nearest]
        for program, tests in mutant.tests + wide:
            if by := copy.test(program, tests):
                return "caught", by
        if everything and (by := copy.all_tests()):
            return "caught", by
        return "survived", ""
    finally:
        copy.restore()


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--build", type=Path, default=ROOT / "build" / "mutants",
                        help="folder of the copy and its build, kept between runs (default: build/mutants)")
    parser.add_argument("--room", action="append", help="only the mutants of ROOM.txt; may be repeated")
    parser.add_argument("--only", action="append", help="only mutants of this name, or pattern; may be repeated")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="of builds (default: all processors)")
    parser.add_argument("--timeout", type=float, default=240,
                        help="seconds of a processor after which a test program hangs, which counts as caught (default: 240)")
    parser.add_argument("--nearest", action="store_true",
                        help="only the tests that a mutant names, not the rest of their programs")
    parser.add_argument("--gate", action="store_true",
                        help="the tests of its programs that .ci/run runs, instead of those that a mutant names")
    parser.add_argument("--all-tests", action="store_true",
                        help="for a mutant that its nearest test programs let pass: all tests (slow)")
    parser.add_argument("--list", action="store_true", help="list the mutants and stop")
    parser.add_argument("--check", action="store_true", help="check that every mutant fits the sources and stop")
    return parser.parse_args()


def main():
    options = arguments()
    try:
        mutants, before = read_mutants()
        problems = check(mutants)
    except Stale as stale:
        problems = [str(stale)]
    if problems:
        print("\n".join(problems), file=sys.stderr)
        return 2
    if options.check:
        print(f"{len(mutants)} mutants fit the sources")
        return 0
    chosen = [m for m in mutants if (not options.room or m.room in options.room) and
              (not options.only or any(fnmatch.fnmatchcase(m.name, only) for only in options.only))]
    if options.list:
        for m in chosen:
            print(f"{m.room:12} {m.name:40} {m.why}")
        return 0
    if not chosen:
        sys.exit("no such mutant")
    copy = Bench(options.build.resolve(), options.jobs, options.timeout)
    copy.update()
    # What is planted is judged by tests that pass without it.
    tests = list(dict.fromkeys(test for m in chosen for test in m.tests))
    commands = [c for room in dict.fromkeys(m.room for m in chosen) for c in before[room]]
    started = time.time()
    if text := copy.make(list(dict.fromkeys([p for p, _ in tests] + [c[0] for c in commands]))):
        sys.exit(f"the sources do not build without a mutant:\n{text[-3000:]}")
    for command in commands:
        if copy.call([str(copy.build / command[0]), *command[1:]])[0] != 0:
            sys.exit(f"{' '.join(command)} fails without a mutant")
    for program in dict.fromkeys(program for program, _ in tests):
        copy.learn(program, [names for of, names in tests if of == program])
    print(f"{len(chosen)} mutants; without one, their tests pass ({time.time() - started:.0f} s)", flush=True)

    gate = copy.gate() if options.gate else None
    results = []
    try:
        for m in chosen:
            started = time.time()
            verdict, by = judge(copy, m, gate, options.nearest, options.all_tests)
            results.append((m, verdict))
            print(f"{verdict:9} {time.time() - started:5.0f} s  {m.room:11} {m.name:44} {by}", flush=True)
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
    copy.restore()
    print()
    for room in dict.fromkeys(m.room for m, _ in results):
        of_room = [verdict for m, verdict in results if m.room == room]
        print(f"{room:12} {of_room.count('caught'):3} of {len(of_room):3} caught")
    for m, verdict in results:
        if verdict != "caught":
            print(f"{verdict}: {m.name} ({m.place}): {m.why}")
    return 0 if all(verdict == "caught" for _, verdict in results) and len(results) == len(chosen) else 1


if __name__ == "__main__":
    processes.stop_on_signals()
    sys.exit(main())
