#!/usr/bin/env python3
"""Draws mutants at random and tells what share of them the tests kill, with its 95 % interval, and which survived. Every
line of product code is as likely, rooms in turn by their share of the lines; then one of the operators (operators.py) that
fit it. What does not compile, or with a warning, is drawn again. The same seed and sources draw the same. One build holds
all of them behind switches (switching.py). Results are kept in build/sample-SEED.jsonl: another run goes on where one
ended."""
import argparse
import hashlib
import json
import os
import random
import re
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from pathlib import Path

import processes
import score
from compiling import Compiler
from judging import START_SECONDS, Judge, in_rounds, time_for
from operators import faults_of
from planting import ROOT
from switched_build import SwitchedBuild
from switching import MANNERS, switched

LEFT_OUT = ("tests/", "viewer/studies/")  # no product code: tests, and programs that measure


def sources(rooms):
    listed = subprocess.run(["git", "-C", ROOT, "ls-files", "*.cpp", "*.h"], check=True, capture_output=True, text=True)
    return [f for f in listed.stdout.split() if not f.startswith(LEFT_OUT) and
            (not rooms or any(f.startswith(room) for room in rooms))]


def room_of(file):
    """The first two folders of a file's path."""
    return "/".join(file.split("/")[:-1][:2])


def places_of(texts, generator):
    """(file, n) of all lines that have a fault: at random in a room, and each room's evenly spread over all."""
    rooms = {}
    for file, lines in sorted(texts.items()):
        rooms.setdefault(room_of(file), []).extend((file, n) for n, line in enumerate(lines) if faults_of(line))
    spread = []
    for room in sorted(rooms):
        generator.shuffle(rooms[room])
        begin = generator.random()
        spread += [((i + begin) / len(rooms[room]), place) for i, place in enumerate(rooms[room])]
    return [place for _, place in sorted(spread)]


def draws(texts, seed):
    """Mutants, at most one of a line, the same for a seed. `texts`: lines by file."""
    generator = random.Random(seed)
    for file, n in places_of(texts, generator):
        faults = faults_of(texts[file][n])
        name = generator.choice(sorted({operator for operator, _ in faults}))
        fault = generator.choice([text for operator, text in faults if operator == name])
        yield {"file": file, "line": n + 1, "room": room_of(file), "operator": name, "before": texts[file][n], "after": fault}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--count", type=int, default=200, help="mutants that build (default: 200)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--room", action="append",
                        help="only files below this folder, such as bricking/store/; may be repeated")
    parser.add_argument("--first", type=float, default=15,
                        help="seconds of a processor for the nearest tests of a mutant, by itself (default: 15)")
    parser.add_argument("--limit", type=float, default=300,
                        help="seconds of a processor for the tests of a mutant that has no switch (default: 300)")
    parser.add_argument("--new-tests", action="store_true",
                        help="judge survivors again, after tests were written: told as a score of its own")
    parser.add_argument("--report", action="store_true", help="tell what is known and stop")
    parser.add_argument("--list", action="store_true", help="print what is drawn and stop")
    parser.add_argument("--build", type=Path, default=ROOT / "build" / "mutants-sampled", help="folder of the copy")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="compilers and tests side by side")
    parser.add_argument("--timeout", type=float, default=120,
                        help="seconds of a processor after which a test hangs without a fault (default: 120)")
    return parser.parse_args()


class Manners:
    """Which of the faults compile, and in which manner each has a switch, kept for runs on the same sources."""

    def __init__(self, path, texts):
        told = hashlib.sha256(json.dumps(sorted(texts.items())).encode()).hexdigest()
        self.path = path.with_suffix(f".{told[:16]}.jsonl")
        self.found = {tuple(entry["of"]): entry["manner"] for entry in score.read(self.path)}

    def add(self, mutant, manner):
        self.found[score.key(mutant)] = manner
        score.append(self.path, {"of": score.key(mutant), "manner": manner})


def compiled(copy, drawn, known, count, keep, manners):
    """The first `count` of what is drawn that compile without a warning, and in which manner each has a switch. `known`:
    verdicts of earlier runs."""
    compiler, chosen, drawn = Compiler(copy), [], iter(drawn)

    def found(mutant):
        """An error, or the number of a manner."""
        if known.get(score.key(mutant)) == "no build":
            return "known"
        if score.key(mutant) in manners.found:
            return manners.found[score.key(mutant)]
        text = (ROOT / mutant["file"]).read_text()
        lines = text.split("\n")
        lines[mutant["line"] - 1] = mutant["after"]
        if error := compiler.error(mutant["file"], "\n".join(lines)):
            return error
        for n, manner in enumerate(MANNERS):
            switch, has = switched(text, [(0, mutant["line"], mutant["operator"], mutant["after"], manner)])
            if has and not compiler.error(mutant["file"], switch):
                return n
        return len(MANNERS)
    with ThreadPoolExecutor(copy.jobs) as threads:
        while len(chosen) < count and (some := list(islice(drawn, count - len(chosen)))):
            for mutant, what in zip(some, threads.map(found, some)):
                if isinstance(what, int):
                    chosen.append((mutant, what))
                    if score.key(mutant) not in manners.found:
                        manners.add(mutant, what)
                elif what != "known":
                    if bad := compiler.error(mutant["file"], (ROOT / mutant["file"]).read_text()):
                        sys.exit(f"{mutant['file']} does not compile without a fault: {bad}")
                    keep(mutant, "no build", what, 0)
    return chosen


def judge_alone(copy, n, tests, options, keep):
    """A fault that has no switch: built by itself, and the tests of its file's other faults, then of its room's."""
    mutant = copy.faults[n]
    copy.planted = (mutant["file"], mutant["line"], mutant["after"])
    try:
        copy.update()
        if text := copy.make(["all"]):
            error = re.search(r"^.*error: .*$", text, re.M)
            return keep(mutant, "no build" if error else "killed", error.group(0)[-200:] if error else "cannot list its tests", 0)

        def near(of):
            own = [copy.faults[m] for m in of["reached"] if m in copy.faults]
            return -sum((m["file"] == mutant["file"]) + 0.1 * (m["room"] == mutant["room"]) for m in own) / (len(own) + 1) / \
                (START_SECONDS + of["seconds"])
        order = [tuple(name.split(" ", 1)) for name in sorted(tests, key=lambda name: near(tests[name]))]
        cost = {test: START_SECONDS + tests[" ".join(test)]["seconds"] for test in order}
        used, met = 0, 0
        for program, names, seconds in in_rounds(order, cost):
            if used > options.limit:
                return keep(mutant, "survived", "", met, whole=False)
            done = copy.run(program, names, set(), time_for(seconds))
            used, met = used + done.seconds, met + len(names)
            if done.by:
                return keep(mutant, "killed", done.by, met)
        return keep(mutant, "survived", "", met)
    finally:
        copy.planted = None


def sampled(options, path, drawn, texts):
    """Judges what is drawn, and keeps."""
    lock = threading.Lock()

    def keep(mutant, verdict, by, met, whole=True):
        with lock:
            score.append(path, {"seed": options.seed, **mutant, "verdict": verdict, "by": by, "met": met, "whole": whole,
                                "new_tests": options.new_tests})
            place = f"{mutant['file']}:{mutant['line']}"
            print(f"{time.strftime('%H:%M:%S')} {verdict:9} {place:60} {mutant['operator']:18} {by or met}", flush=True)
    known = {score.key(result): result["verdict"] for result in score.read(path)}
    copy = SwitchedBuild(options.build.resolve(), options.jobs, options.timeout)
    copy.configure()
    chosen = compiled(copy, drawn, known, options.count, keep, Manners(copy.root / "build" / "compiled", texts))
    copy.set_faults(chosen)
    tests = copy.prepare()
    wanted = {n for n, mutant in copy.faults.items() if
              (known.get(score.key(mutant)) == "survived" if options.new_tests else score.key(mutant) not in known)}
    alone = copy.alone(tests)
    judge = Judge(copy.run, tests, copy.faults, lambda n, *found: keep(copy.faults[n], *found), options.jobs)
    judge.judge(wanted - alone, options.first)
    for n in sorted(wanted & alone):
        judge_alone(copy, n, tests, options, keep)


def main():
    options = arguments()
    path = ROOT / "build" / f"sample-{options.seed}.jsonl"
    texts = {file: (ROOT / file).read_text().split("\n") for file in sources([])}
    of_rooms = set(sources(options.room))
    drawn = draws({file: lines for file, lines in texts.items() if file in of_rooms}, options.seed)
    if options.list:
        for mutant in islice(drawn, options.count):
            print(f"{mutant['file']}:{mutant['line']}: {mutant['operator']}\n- {mutant['before'].strip()}\n+ {mutant['after'].strip()}")
        return 0
    if not options.report:
        sampled(options, path, drawn, texts)
    print(score.report(score.read(path), score.read(score.EQUIVALENT)))
    return 0


if __name__ == "__main__":
    processes.stop_on_signals()
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit("stopped; what was judged is kept")
