#!/usr/bin/env python3
"""What sample.py draws: by the operators, the same for a seed, such as planted() can plant; the order and the limits of
tests; and what score.py tells."""
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from collections import Counter
from itertools import islice
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import gcov
import processes
import score
from operators import OPERATORS, faults_of
from planting import Tested, planted
from processes import Limits
from reach import Reach, in_rounds
from sample import draws, judge, room_of, unbuilt

EXPECTED = [  # line, operator, one of its faults
    ("    if (a < b)", "comparison", "    if (a <= b)"),
    ("    x = a + b;", "sign", "    x = a - b;"),
    ("    if (a && b)", "logic", "    if (a || b)"),
    ("    n = count - 1;", "off by one", "    n = count;"),
    ("    x = std::min(f(a, b), c);", "dropped clamp", "    x = (f(a, b));"),
    ("    x = f(a, b);", "swapped arguments", "    x = f(b, a);"),
    ("    x = 3 * y;", "constant", "    x = (2 * 3) * y;"),
    ("    return x + 1;", "early return", "    return {};"),
    ("    if (f(a))", "negated condition", "    if (!(f(a)))"),
    ("    ++count;", "dropped statement", "    {}"),
    ("    x = p.x;", "axis", "    x = p.y;"),
    ("    x = mm * spacing;", "unit factor", "    x = mm;"),
]
NONE = ["// a < b", "#include <a>", "}", "", "static_assert(a < b);", '    "a < b"', "    all.reserve(n + 1);"]
LINES = [line for line, _, _ in EXPECTED] * 2 + ["end;"]
TEXTS = {"core/scene/a.cpp": ["// a.cpp: one"] + LINES * 3, "render/b.cpp": ["// b.cpp: two", "    x = 1;", "    y = x - 1;"]}


def result(verdict, n, new_tests=False):
    return {"file": "core/a.cpp", "line": n, "room": "core", "operator": "sign", "before": f"a + {n}", "after": f"a - {n}",
            "verdict": verdict, "whole": True, "new_tests": new_tests}


class Operators(unittest.TestCase):
    def test_each_has_its_faults(self):
        for line, operator, fault in EXPECTED:
            self.assertIn((operator, fault), faults_of(line))
        self.assertEqual({operator for _, operator, _ in EXPECTED}, set(OPERATORS))

    def test_what_does_not_run_has_none(self):
        for line in NONE:
            self.assertEqual(faults_of(line), [])

    def test_declarations_keep_their_parameters(self):
        self.assertNotIn("swapped arguments", dict(faults_of("int f(int a, const B& b);")))

    def test_what_changes_nothing_is_none(self):
        self.assertNotIn("swapped arguments", dict(faults_of("    x = std::max(a, b);")))
        self.assertEqual(faults_of("    return nullptr;"), [])
        self.assertIn(("constant", "    x = 1.0f;"), faults_of("    x = 0.0f;"))


class Draws(unittest.TestCase):
    def test_repeat_with_the_seed_and_end(self):
        first = [mutant for mutant, _ in draws(TEXTS, 5)]
        self.assertEqual(first, [mutant for mutant, _ in draws(TEXTS, 5)])
        self.assertNotEqual(first, [mutant for mutant, _ in draws(TEXTS, 6)])
        self.assertEqual(len({(mutant["file"], mutant["line"]) for mutant in first}), len(first), "one of a line")

    def test_can_be_planted(self):
        for mutant, planting in draws(TEXTS, 5):
            edit, whole = planting.edits[0], "\n".join(TEXTS[mutant["file"]])
            lines = planted(edit, whole, "").split("\n")
            self.assertEqual([(n + 1, new) for n, (old, new) in enumerate(zip(whole.split("\n"), lines)) if old != new],
                             [(mutant["line"], mutant["after"])])

    def test_take_rooms_by_their_share(self):
        texts = {"a/b/one.cpp": ["    x = 1;"] * 30, "c/two.cpp": ["    x = 1;"] * 10, "a/b/d/three.cpp": ["    x = 1;"] * 20}
        texts = {file: [f"{line} // {n}" for n, line in enumerate(lines)] for file, lines in texts.items()}
        for seed in range(20):
            rooms = [mutant["room"] for mutant, _ in islice(draws(texts, seed), 12)]
            self.assertIn(rooms.count("c"), (1, 2, 3))
        self.assertEqual(room_of("a/b/d/three.cpp"), "a/b")


def reach_of(*tests):
    """Of (program, test, seconds, functions), a function being its file and a name."""
    reach = object.__new__(Reach)
    reach.seconds, reach.ran, reach.files = {}, {}, {}
    reach.functions = lambda file, line: {f"{file} {line}"}
    for program, name, seconds, ran in tests:
        reach.seconds.setdefault(program, {})[name] = seconds
        reach.ran.setdefault(program, {})[name] = set(ran)
        reach.files.setdefault(program, {})[name] = Counter(function.split()[0] for function in ran)
    reach.programs = lambda file: list(reach.ran)
    return reach


class Order(unittest.TestCase):
    WIDE = [f"b.cpp {n}" for n in range(50)]

    def test_only_tests_that_reach_the_line(self):
        reach = reach_of(("p", "one", 1, ["a.cpp 1"]), ("p", "other", 1, ["a.cpp 2"]), ("q", "two", 1, ["a.cpp 1", "b.cpp 1"]))
        self.assertEqual([(program, names) for program, names, _ in reach.tests("a.cpp", 1)], [("p", ["one"]), ("q", ["two"])])

    def test_specific_tests_first_then_short_ones(self):
        reach = reach_of(("p", "wide", 10, ["a.cpp 1"] + self.WIDE), ("q", "own", 10, ["a.cpp 1", "a.cpp 2"]),
                         ("r", "short", 0.1, ["a.cpp 1"] + self.WIDE))
        self.assertEqual([names for _, names, _ in reach.tests("a.cpp", 1)], [["own"], ["short"], ["wide"]])

    def test_join_short_ones_of_a_program(self):
        tests = [("p" if n % 2 else "q", str(n)) for n in range(100)]
        found = in_rounds(tests, {test: 1.0 for test in tests})
        self.assertEqual(sorted(name for _, names, _ in found for name in names), sorted(name for _, name in tests))
        self.assertLess(len(found), 12)
        self.assertEqual(found[0], ("q", ["0", "2", "4"], 3.0))
        self.assertEqual(sum(seconds for _, _, seconds in found), 100)


class Told:
    """A copy whose tests take so many seconds of a processor, and fail or not."""

    def __init__(self, *tests, same=()):
        self.left, self.same, self.restored, self.timeout = list(tests), same, False, 100

    def plant(self, mutant):
        pass

    def restore(self):
        self.restored = True

    def make(self, targets):
        return ""

    def is_changed(self, program):
        return program not in self.same

    def run_tests(self, program, tests, timeout):
        seconds, by = self.left.pop(0)
        return Tested(by, "", seconds)


class Judged(unittest.TestCase):
    TESTS = [("p", ["a"], 1), ("p", ["b"], 1), ("q", ["c"], 1)]

    def test_by_the_first_that_fails(self):
        copy = Told((1, ""), (2.5, "b"))
        found = judge(copy, self.TESTS, None, 10)
        self.assertEqual((found["verdict"], found["by"], found["processor"], copy.restored), ("killed", "b", 3.5, True))

    def test_until_its_processor_time_is_up(self):
        found = judge(Told((6, ""), (6, "")), self.TESTS, None, 10)
        self.assertEqual((found["verdict"], found["whole"], found["tests"], found["reached"]), ("survived", False, ["p a", "p b"], 3))
        self.assertTrue(judge(Told((6, ""), (1, ""), (6, "")), self.TESTS, None, 10)["whole"])

    def test_not_by_programs_that_are_the_same(self):
        found = judge(Told((6, ""), same=["p"]), self.TESTS, None, 10)
        self.assertEqual((found["verdict"], found["tests"], found["whole"], found["same"]), ("survived", ["q c"], True, False))
        found = judge(Told(same=["p", "q"]), self.TESTS, None, 10)
        self.assertEqual((found["verdict"], found["tests"], found["whole"], found["same"]), ("survived", [], True, True))

    def test_only_in_part_where_this_program_ends(self):
        def stopped(*_):
            raise processes.Stopped
        copy = Told()
        copy.run_tests = stopped
        self.assertRaises(processes.Stopped, judge, copy, self.TESTS, None, 10)
        self.assertTrue(copy.restored)


def lives(process):
    try:
        return Path(f"/proc/{process}/stat").read_text().split()[2] != "Z"
    except FileNotFoundError:
        return False


def within(seconds, condition):
    until = time.time() + seconds
    while not condition() and time.time() < until:
        time.sleep(0.02)
    return condition()


# What runs a command, is ended, and leaves the numbers of the command and of what that started.
ENDED = """import sys
sys.path.insert(0, sys.argv[1])
import processes
processes.stop_on_signals()
processes.run(["sh", "-c", "sleep 60 & echo $$ $! > two; mv two told; wait"], sys.argv[2], None)
"""


class Processes(unittest.TestCase):
    BUSY = "import time\nwhile time.process_time() < 0.4: pass"

    def run_it(self, *command, **limits):
        return processes.run(command, "/tmp", None, Limits(**limits))

    def test_time_is_of_processors_and_of_all_that_was_started(self):
        done = self.run_it("sh", "-c", f"{sys.executable} -c '{self.BUSY}'; sleep 0.2; echo said; exit 3")
        self.assertEqual((done.status, done.text), (3, "said\n"))
        self.assertGreater(done.seconds, 0.35)
        self.assertLess(self.run_it("sleep", "0.4").seconds, 0.2)

    def test_hang_by_processor_and_by_clock(self):
        begun = time.time()
        done = self.run_it("sh", "-c", "while :; do :; done", processor=0, clock=60)
        self.assertEqual(done.status, None)
        self.assertGreater(done.seconds, 0.8)
        self.assertEqual(self.run_it("sleep", "60", clock=0.1).status, None)
        self.assertEqual(self.run_it("sh", "-c", "sleep 60 & wait", idle=1, clock=60).status, None)
        busy = "import time\nwhile time.process_time() < 1.5: pass"
        self.assertEqual(self.run_it(sys.executable, "-c", busy, idle=1, clock=60).status, 0, "slow is no hang")
        self.assertLess(time.time() - begun, 40)

    def test_leave_nobody(self):
        for rest in ("", "; wait"):
            done = self.run_it("sh", "-c", "sleep 60 & echo $!" + rest, clock=0.5)
            self.assertTrue(within(5, lambda: not lives(int(done.text))))

    def test_end_with_their_program(self):
        for number, whole in ((signal.SIGTERM, True), (signal.SIGINT, True), (signal.SIGKILL, False)):
            with self.subTest(number), tempfile.TemporaryDirectory() as folder:
                told = Path(folder) / "told"
                program = subprocess.Popen([sys.executable, "-c", ENDED, str(Path(__file__).parent), folder],
                                           stderr=subprocess.DEVNULL)
                self.assertTrue(within(10, told.exists))
                command, started = map(int, told.read_text().split())
                program.send_signal(number)
                self.assertNotEqual(program.wait(10), 0)
                self.assertTrue(within(5, lambda: not lives(command)))
                self.assertTrue(not whole or within(5, lambda: not lives(started)))
                if lives(started):
                    os.kill(started, signal.SIGKILL)


class Score(unittest.TestCase):
    def test_interval(self):
        low, high = score.wilson(8, 10)  # Wilson 1927
        self.assertAlmostEqual(low, 0.4902, 3)
        self.assertAlmostEqual(high, 0.9433, 3)
        self.assertEqual(score.wilson(0, 0), (0.0, 1.0))
        self.assertEqual(score.wilson(5, 5)[1], 1.0)

    def test_tells_new_tests_and_equivalents_apart(self):
        results = [result("killed", 1), result("survived", 2), result("survived", 3), result("survived", 4),
                   result("no build", 5), result("killed", 2), result("killed", 3, True)]
        text = score.report(results, [dict(result("", 4), because="it is nothing")])
        self.assertIn("2 of 4 killed, 50 %", text, "what was judged again counts by what came last")
        self.assertIn("1 more did not build", text)
        self.assertIn("without 1 argued equivalent: 2 of 3", text)
        self.assertIn("written for survivors: 3 of 3", text)
        self.assertIn("equivalent: it is nothing", text)
        text = score.report([result("killed", 1), dict(result("survived", 2), same=True)], [])
        self.assertIn("without 1 argued equivalent: 1 of 1", text)

    def test_is_kept_between_runs(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "build" / "sample.jsonl"
            self.assertEqual(score.read(path), [])
            score.append(path, result("killed", 1))
            score.append(path, result("survived", 2))
            self.assertEqual(score.read(path), [result("killed", 1), result("survived", 2)])

    def test_only_compilers_errors_are_no_mutant(self):
        self.assertIn("no such thing", unbuilt("a.cpp:1:2: error: no such thing\n"))
        self.assertEqual(unbuilt("CMake Error at X: Error running test executable.\n"), "")

PROGRAM = """#include "inlined.h"
__attribute__((noinline)) int runs(int n)
{
    return inlined(n) + 1;
}
__attribute__((noinline)) int rests(int n)
{
    return n + 2;
}
int main(int count, char**)
{
    return count > 1 ? rests(count) : runs(count) - 2;
}
"""


class Counters(unittest.TestCase):
    def test_tell_lines_and_what_ran(self):
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "inlined.h").write_text("volatile int v;\ninline int inlined(int n)\n{\n    return n + v;\n}\n")
            (Path(folder) / "a.cpp").write_text(PROGRAM)
            subprocess.run(["g++", "-O2", "--coverage", "a.cpp", "-o", "a"], cwd=folder, check=True)
            counts = dict(os.environ, GCOV_PREFIX=folder + "/counts", GCOV_PREFIX_STRIP="0")
            subprocess.run([folder + "/a"], check=True, env=counts)
            notes = gcov.lines_of(next(Path(folder).glob("*.gcno")))
            ran = gcov.ran(next((Path(folder) / "counts").rglob("*.gcda")))
            self.assertEqual({notes[function][0] for function in ran}, {("a.cpp", 2, 5), ("a.cpp", 10, 13)})
            self.assertEqual({place for place, _, _ in notes.values()} - {notes[function][0] for function in ran}, {("a.cpp", 6, 9)})
            self.assertIn(("inlined.h", 4), set().union(*(notes[function][2] for function in ran)))

    def test_of_another_kind_are_refused(self):
        with tempfile.NamedTemporaryFile() as file:
            file.write(b"nothing of the kind")
            file.flush()
            self.assertRaises(ValueError, gcov.lines_of, file.name)
            self.assertRaises(ValueError, gcov.ran, file.name)


if __name__ == "__main__":
    unittest.main()
