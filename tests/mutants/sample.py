#!/usr/bin/env python3
"""Draws mutants at random, plants them one at a time and tells what share of them the tests kill, with its 95 %
interval, and which survived. Every line of product code is as likely, rooms in turn by their share of the lines; then
one of the operators (operators.py) that fit it. What does not compile, or with a warning, is drawn again. The same
seed and sources draw the same. Results are kept in build/sample-SEED.jsonl: another run goes on where one ended.
Exit status: 0 where the sample is whole, 1 where time was up before."""
import argparse
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
from operators import faults_of
from planting import ROOT, Copy, Edit, Mutant
from reach import Reach

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
        above = texts[file][:n]  # they make the old text stand once in its file
        edit = Edit(file, above + [texts[file][n]], above + [fault])
        yield {"file": file, "line": n + 1, "room": room_of(file), "operator": name, "before": texts[file][n],
               "after": fault}, Mutant("sample", name, f"{file}:{n + 1}", name, [edit])


def judge(copy, tests, mutant, limit):
    """Plants a mutant and runs the tests that reach it until they have taken their processor time; what a result says of
    that."""
    ran, built, begun, used = [], {}, time.time(), 0  # built: whether the program is another with the mutant

    def found(verdict, by, whole=True):
        return {"verdict": verdict, "by": by, "tests": ran, "whole": whole, "reached": sum(len(names) for _, names, _ in tests),
                "seconds": round(time.time() - begun, 1), "processor": round(used, 1),
                "same": whole and bool(built) and not any(built.values())}
    try:
        copy.plant(mutant)
        if not tests and (error := unbuilt(copy.make(["all"]))):
            return found("no build", error)
        for program, names, seconds in tests:
            if used > limit:
                return found("survived", "", False)
            if program not in built and (text := copy.make([program])):
                if error := unbuilt(text):
                    return found("no build", error)
                return found("killed", f"{program}: cannot list its tests")
            if program not in built:
                built[program] = copy.is_changed(program)
            if not built[program]:
                continue
            ran.append(f"{program} {names[0] if len(names) == 1 else len(names)}")
            done = copy.run_tests(program, ":".join(names), min(copy.timeout, 30 + 10 * seconds))
            used += done.seconds
            if done.by:
                return found("killed", done.by)
        return found("survived", "")
    finally:
        copy.restore()


def unbuilt(text):
    """The first error of a compiler or linker; "" where a build failed by what it ran."""
    error = re.search(r"^.*error: .*$", text, re.M)
    return error.group(0)[-200:] if error else ""


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--count", type=int, default=200,
                        help="mutants that build, with those of earlier runs (default: 200)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--room", action="append",
                        help="only files below this folder, such as bricking/store/; may be repeated")
    parser.add_argument("--minutes", type=float, default=1e9, help="begin nothing more after so many")
    parser.add_argument("--limit", type=float, default=300, help="seconds of a processor for the tests of a mutant that lives (default: 300)")
    parser.add_argument("--again", action="store_true", help="judge survivors again: with a longer --limit")
    parser.add_argument("--new-tests", action="store_true",
                        help="as --again, after tests were written: told as a score of its own")
    parser.add_argument("--report", action="store_true", help="tell what is known and stop")
    parser.add_argument("--list", action="store_true", help="print what is drawn and stop")
    parser.add_argument("--build", type=Path, default=ROOT / "build" / "mutants",
                        help="folder of the first copy, as run.py has it; others beside it")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="mutants side by side, each in its copy")
    parser.add_argument("--timeout", type=float, default=120,
                        help="seconds of a processor after which tests hang: a kill (default: 120)")
    return parser.parse_args()


def prepared(folder, options):
    """A copy, built and with its stores."""
    copy = Copy(folder.resolve(), options.jobs, options.timeout)
    copy.update()
    if text := copy.make(["all"]):
        sys.exit(f"the sources do not build without a mutant:\n{text[-3000:]}")
    stores = copy.build / "test-stores"
    prepare = [str(copy.build / "prepare_test_stores"), str(stores)]
    if not stores.exists() and copy.call(prepare, 20 * options.timeout)[0] != 0:
        sys.exit("prepare_test_stores fails without a mutant")
    return copy


def wanted(options, results, drawn):
    """What is to be judged, and how many of them that build."""
    if options.again or options.new_tests:
        alive = {name for name, result in score.judged(results, True).items() if result["verdict"] == "survived"}
        return [(mutant, planted) for mutant, planted in drawn if score.key(mutant) in alive], len(alive)
    known = {score.key(result) for result in results}
    return ((mutant, planted) for mutant, planted in drawn if score.key(mutant) not in known), \
        options.count - len(score.judged(results, False))


def sampled(options, copies, path, drawn):
    """Judges in all copies at once, and keeps; returns whether all were."""
    reach, until, one = Reach(copies[0]), time.time() + 60 * options.minutes, threading.Lock()
    chosen, left = wanted(options, score.read(path), drawn)
    chosen = iter(chosen)
    for copy in copies:
        copy.jobs = 1
        copy.remember(reach.parts)

    def work(copy):
        nonlocal left
        while True:
            with one:
                if left <= 0 or time.time() > until or (mutant := next(chosen, None)) is None:
                    return
                left -= 1
                tests = reach.tests(mutant[0]["file"], mutant[0]["line"])
            result = {"seed": options.seed, **mutant[0], **judge(copy, tests, mutant[1], options.limit),
                      "new_tests": options.new_tests}
            with one:
                score.append(path, result)
                left += result["verdict"] == "no build"
                print(f"{result['verdict']:9} {result['seconds']:5.0f} s {result['processor']:5.0f} s  {mutant[1].place:60} {mutant[1].why:18} "
                      f"{result['by'] or result['reached']}", flush=True)
    with ThreadPoolExecutor(len(copies)) as threads:
        list(threads.map(work, copies))
    return left <= 0


def main():
    options = arguments()
    path = ROOT / "build" / f"sample-{options.seed}.jsonl"
    texts = {file: (ROOT / file).read_text().split("\n") for file in sources(options.room)}
    drawn, whole = draws(texts, options.seed), True
    if options.list:
        for mutant, planted in islice(drawn, options.count):
            print(f"{planted.place}: {planted.why}\n- {mutant['before'].strip()}\n+ {mutant['after'].strip()}")
        return 0
    if not options.report:
        folders = [options.build] + [options.build.with_name(f"{options.build.name}-{n}") for n in range(2, options.jobs + 1)]
        whole = sampled(options, [prepared(folder, options) for folder in folders], path, drawn)
    print(score.report(score.read(path), score.read(score.EQUIVALENT)))
    return 0 if whole else 1


if __name__ == "__main__":
    processes.stop_on_signals()
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit("stopped; what was judged is kept")
