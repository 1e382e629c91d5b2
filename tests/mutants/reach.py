"""Which tests reach a line: learnt once by running every test alone in a build that counts what runs, and kept beside
that build. A program is learnt again when its tests change. What a change of the product makes its tests run besides is
not seen until then: `rm -r build/mutants/build/coverage/learnt` after a large one."""
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import gcov
import processes

START_SECONDS = 0.5  # to start a test, and a share of what it takes to link its program
FIRST_SECONDS, MORE = 5.0, 4  # of the first tests, and how much longer later ones may run together


class Build:
    """A build of the copy: what it is made of, and its tests."""

    def __init__(self, copy, folder):
        self.copy, self.folder, self.includers, self.made = copy, folder, {}, {}

    def ninja(self, *arguments):
        return subprocess.run(["ninja", "-C", self.folder, *arguments], check=True, capture_output=True,
                              text=True).stdout.split("\n")

    def place(self, path):
        """A path as the build has it, from the root of the sources; headers are found by links in the build folder."""
        if path not in self.made:
            self.made[path] = os.path.relpath(os.path.realpath(self.folder / path), self.copy.root)
        return self.made[path]

    def objects_with(self, file):
        """Objects that compile a file, or include it."""
        if not self.includers:
            of = ""
            for line in self.ninja("-t", "deps"):
                if line.startswith("    "):
                    self.includers.setdefault(self.place(line.strip()), set()).add(of)
                elif ":" in line:
                    of = line.split(":")[0]
        return self.includers.get(file, set())

    def sources(self, program):
        """Files below tests/ that a program is made of."""
        own = f"tests/CMakeFiles/{program}.dir/"
        self.objects_with("")
        return sorted(file for file, objects in self.includers.items() if file.startswith("tests/") and
                      any(of.startswith(own) for of in objects))

    def tests(self):
        """Tests by program, {program: {name: command}}: all but pictures of engines, of which those of `.ci/run`."""
        pictures = subprocess.run(["bash", "-c", "source .ci/tests.sh && echo \"$one_a_feature|$one_store\""], check=True,
                                  cwd=self.copy.root, capture_output=True, text=True).stdout.strip()
        listed = subprocess.run(["ctest", "--test-dir", self.folder, "--show-only=json-v1"], check=True, env=self.copy.env,
                                capture_output=True, text=True).stdout
        found = {}
        for test in json.loads(listed)["tests"]:
            command = test.get("command", [""])
            names = [word.split("=", 1)[1] for word in command if word.startswith("--gtest_filter=")]
            picture = any("image" in kind["value"] for kind in test["properties"] if kind["name"] == "LABELS")
            program = Path(command[0]).name
            if names and (not (picture and program.startswith("render_")) or re.search(pictures, test["name"])):
                found.setdefault(program, {})[names[0]] = command
        return found


class Reach:
    def __init__(self, copy):
        self.copy, self.release = copy, Build(copy, copy.build)
        self.counted = Build(copy, copy.root / "build" / "coverage")
        inputs = {p: self.release.ninja("-t", "inputs", p) for p in self.release.tests()}
        self.objects = {p: {line for line in of if line.endswith(".o")} for p, of in inputs.items()}
        # Objects, and the programs and modules at the top of the build.
        self.parts = {p: {p} | {line for line in of if line.endswith((".o", ".so")) or "/" not in line}
                      for p, of in inputs.items()}
        self.lines, self.places = {}, {}  # functions by a file's lines with code, and by (first, last) line
        # By program and test: seconds, functions, and how many of them each file of the product has.
        self.seconds, self.ran, self.files = {}, {}, {}
        self.learn()

    def learn(self):
        """Builds with counters, runs what is not known yet, and reads all."""
        configure = ["cmake", "-S", self.copy.root, "-B", self.counted.folder, *self.copy.CONFIGURE,
                     "-DCMAKE_COMPILE_WARNING_AS_ERROR=OFF", "-DTESSERA_WITH_TESTS=ON", "-DCMAKE_CXX_FLAGS=--coverage"]
        for command in (configure, ["ninja", "-C", self.counted.folder, "-j", self.copy.jobs]):
            done = processes.run(command, self.copy.root, self.copy.env)
            if done.status != 0:
                sys.exit(f"the sources do not build with counters:\n{done.text[-3000:]}")
        stores = self.counted.folder / "test-stores"
        if not stores.exists():
            self.copy.call([str(self.counted.folder / "prepare_test_stores"), str(stores)], 40 * self.copy.timeout)
        identities = {}  # by object: functions, which are (source, mangled name)
        for notes in sorted(self.counted.folder.rglob("*.gcno")):
            own = identities[str(notes.relative_to(self.counted.folder))[:-len(".gcno")]] = {}
            for identity, ((source, first, last), name, lines) in gcov.lines_of(notes).items():
                place = self.counted.place(source)
                own[identity] = f"{place} {name}"
                self.places.setdefault(place, {}).setdefault((first, last), set()).add(own[identity])
                for source, line in lines:
                    self.lines.setdefault(self.counted.place(source), {}).setdefault(line, set()).add(own[identity])
        for program, tests in self.counted.tests().items():
            self.learn_program(program, tests, identities)

    def learn_program(self, program, tests, identities):
        text = [*tests] + [(self.copy.root / file).read_text() for file in self.counted.sources(program)]
        state = hashlib.sha256("".join(text).encode()).hexdigest()
        path = self.counted.folder / "learnt" / f"{program}.json"
        known = json.loads(path.read_text()) if path.exists() else {}
        if known.get("state") != state:
            begun = time.time()
            with ThreadPoolExecutor(self.copy.jobs) as threads:
                found = dict(zip(tests, threads.map(lambda test: self.count(*test, identities), tests.items())))
            found = {name: told for name, told in found.items() if told}
            functions = sorted(set().union(*(told["ran"] for told in found.values())))
            number = {function: n for n, function in enumerate(functions)}
            for told in found.values():
                told["ran"] = sorted(number[function] for function in told["ran"])
            known = {"state": state, "functions": functions, "tests": found}
            path.parent.mkdir(exist_ok=True)
            path.write_text(json.dumps(known))
            print(f"learnt {program}: {len(found)} of {len(tests)} tests, {time.time() - begun:.0f} s", flush=True)
        functions = known["functions"]
        self.seconds[program] = {name: told["seconds"] for name, told in known["tests"].items()}
        self.ran[program] = {name: {functions[n] for n in told["ran"]} for name, told in known["tests"].items()}
        place = [function.split(" ")[0] for function in functions]
        self.files[program] = {name: Counter(place[n] for n in told["ran"] if not place[n].startswith(("..", "tests/")))
                               for name, told in known["tests"].items()}

    def count(self, name, command, identities):
        """A test's seconds of a processor, and the functions that it, and what it starts, runs; None where it does not pass."""
        folder = self.copy.root / "build" / "counts" / hashlib.sha256(name.encode()).hexdigest()[:16]
        strip = len(self.counted.folder.parts) - 1
        env = dict(self.copy.env, GCOV_PREFIX=str(folder), GCOV_PREFIX_STRIP=str(strip))
        try:
            done, ran = self.copy.call(command, 10 * self.copy.timeout, env), set()
            if done.status != 0:
                return None
            for counts in folder.rglob("*.gcda"):
                own = identities.get(str(counts.relative_to(folder))[:-len(".gcda")], {})
                ran |= {own[identity] for identity in gcov.ran(counts) if identity in own}
            return {"seconds": round(done.seconds, 2), "ran": ran}
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def functions(self, file, line):
        """Functions that hold a line: by their code, and the innermost around it; None where it is in none, such as a
        constant."""
        around = [(last - first, of) for (first, last), of in self.places.get(file, {}).items() if first <= line <= last]
        least = min(around, default=(0, set()), key=lambda function: function[0])[0]
        found = self.lines.get(file, {}).get(line, set()).union(*(of for size, of in around if size == least))
        return found or None

    def programs(self, file):
        """Test programs that hold a file, the nearest first: those whose tests include its header, then those that
        include most from its folder, then those that hold the fewest objects."""
        objects, folder = self.release.objects_with(file), os.path.dirname(file)

        def distance(program):
            names = [name for source in self.release.sources(program) if source.endswith(".cpp")
                     for name in re.findall(r'#include "(.+)"', (self.copy.root / source).read_text())]
            near = sum(os.path.dirname(name) == folder for name in names) / max(len(names), 1)
            return os.path.splitext(file)[0] + ".h" not in names, -near, len(self.objects[program]), program
        return sorted((p for p in self.objects if self.objects[p] & objects), key=distance)

    def tests(self, file, line):
        """Tests that reach a line, (program, names, seconds): those first that meet a fault most likely in a second. The
        likelihood is taken for the share of the file among the functions that a test runs."""
        functions, likely = self.functions(file, line), {}
        for program in self.programs(file):
            for name, ran in self.ran[program].items():
                if functions is None or not functions.isdisjoint(ran):
                    of = self.files[program][name]
                    likely[program, name] = (of.get(file, 0) + 1) / (sum(of.values()) + 1)
        cost = {test: START_SECONDS + self.seconds[test[0]][test[1]] for test in likely}
        return in_rounds(sorted(likely, key=lambda test: -likely[test] / cost[test]), cost)


def in_rounds(ordered, cost):
    """Joins tests that run one after another in one program: few at first, later more. `ordered`: (program, name), the
    first first; `cost`: their seconds."""
    rounds, most, taken = [{}], FIRST_SECONDS, 0
    for program, name in ordered:
        if taken > most:
            rounds, most, taken = rounds + [{}], MORE * most, 0
        rounds[-1].setdefault(program, []).append(name)
        taken += cost[program, name]
    return [(program, names, sum(cost[program, name] for name in names)) for of in rounds for program, names in of.items()]
