#!/usr/bin/env python3
"""What sample.py draws: by the operators, the same for a seed; switches that are the faults they stand for; the order and
the limits of tests; and what score.py tells."""
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from itertools import islice
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import processes
import score
from judging import Judge, in_rounds
from operators import OPERATORS, faults_of
from planting import Tested
from processes import Limits
from sample import Manners, draws, room_of
from switched_build import SwitchedBuild
from switching import MANNERS, switched

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
            "verdict": verdict, "met": 1, "whole": True, "new_tests": new_tests}


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
        first = list(draws(TEXTS, 5))
        self.assertEqual(first, list(draws(TEXTS, 5)))
        self.assertNotEqual(first, list(draws(TEXTS, 6)))
        self.assertEqual(len({(mutant["file"], mutant["line"]) for mutant in first}), len(first), "one of a line")

    def test_take_rooms_by_their_share(self):
        texts = {"a/b/one.cpp": ["    x = 1;"] * 30, "c/two.cpp": ["    x = 1;"] * 10, "a/b/d/three.cpp": ["    x = 1;"] * 20}
        texts = {file: [f"{line} // {n}" for n, line in enumerate(lines)] for file, lines in texts.items()}
        for seed in range(20):
            rooms = [mutant["room"] for mutant in islice(draws(texts, seed), 12)]
            self.assertIn(rooms.count("c"), (1, 2, 3))
        self.assertEqual(room_of("a/b/d/three.cpp"), "a/b")


SOURCE = r"""// A source of faults.
#include <algorithm>
#include <array>
#include <cstdio>
namespace {
constexpr int kMost = 7; // of a class
template <class T>
T limited(T a, T b)
{
    return std::max<T>(a - 1, b);
}
constexpr int twice(int n)
{
    return n * 2;
}
struct Point {
    int x = 1, y{2};
    static constexpr int kSide = 3;
};
int chosen(int n)
{
    constexpr int kOwn = 5;
    if (n > 3 && // and
        n < kMost)
        n += 2;
    else
        n = -n;
    std::array<int, 2> both{limited(n,
                                    kOwn + 1), twice(n)};
    for (int& one : both)
        ++one;
    Point p;
    p.x = both[0];
    const auto add = [&](int a, int b) { return a * 10 + b; };
    return n == 8 ? p.y : add(p.x, both[1]) + Point::kSide;
}
}
int main(int count, char**)
{
    for (int n = 0; n < 9; ++n)
        std::printf("%d%c", chosen(n + count - 1), n == 8 ? '\\n' : ' ');
}
"""
# A fault of a line of it: (line, operator, what the line is with it)
FAULTS = [(6, "constant", "constexpr int kMost = (2 * 7); // of a class"), (10, "off by one", "    return std::max<T>(a, b);"),
          (14, "early return", "    return {};"), (17, "constant", "    int x = 1, y{(2 * 2)};"),
          (18, "constant", "    static constexpr int kSide = (2 * 3);"), (22, "constant", "    constexpr int kOwn = (2 * 5);"),
          (23, "logic", "    if (n > 3 || // and"), (24, "comparison", "        n <= kMost)"), (25, "sign", "        n -= 2;"),
          (27, "dropped statement", "        {}"),
          (29, "sign", "                                    kOwn - 1), twice(n)};"), (31, "dropped statement", "        {}"),
          (33, "axis", "    p.y = both[0];"), (34, "swapped arguments", "    const auto add = [&](int b, int a) { return a * 10 + b; };"),
          (35, "swapped arguments", "    return n == 8 ? p.y : add(both[1], p.x) + Point::kSide;"),
          (40, "negated condition", "    for (int n = 0; !(n < 9); ++n)")]


class Switches(unittest.TestCase):
    def program(self, folder, name, text, *more):
        (folder / f"{name}.cpp").write_text(text)
        done = subprocess.run(["g++", "-std=c++20", f"{name}.cpp", *more, "-o", name], cwd=folder, capture_output=True, text=True)
        return folder / name if done.returncode == 0 else None

    def said(self, program, **env):
        return subprocess.run([program], env=dict(os.environ, **env), capture_output=True, check=True).stdout

    def test_are_the_faults_that_they_stand_for(self):
        """Each alone, and all in one program: with one it says what the source with that fault says, without what it said."""
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            library = [str(folder / "faults.so")]
            subprocess.run(["gcc", "-shared", "-fPIC", Path(__file__).with_name("faults.c"), "-o", library[0]], check=True)
            own, chosen = self.said(self.program(folder, "own", SOURCE)), []
            for n, (line, operator, after) in enumerate(FAULTS):
                for manner in MANNERS:
                    fault = (n, line, operator, after, manner)
                    text, lines = switched(SOURCE, [fault])
                    self.assertEqual(text.count("\n"), SOURCE.count("\n"))
                    if lines and self.program(folder, "one", text, *library):
                        self.assertTrue(lines[n][0] <= line <= lines[n][1])
                        chosen.append(fault)
                        break
            self.assertEqual([n for n, *_ in chosen], [n for n in range(len(FAULTS)) if FAULTS[n][0] != 34], "parameters have no switch")
            text, lines = switched(SOURCE, chosen)
            self.assertEqual(sorted(lines), [n for n, *_ in chosen])
            program = self.program(folder, "all", text, *library)
            self.assertEqual(self.said(program), own)
            for n, line, _, after, _ in chosen:
                faulty = SOURCE.split("\n")
                faulty[line - 1] = after
                faulty = self.said(self.program(folder, "faulty", "\n".join(faulty)))
                self.assertEqual(self.said(program, TESSERA_FAULTS=f"99,{n}"), faulty, f"line {line}")
                self.assertNotEqual(faulty, own, f"line {line} is no fault")
            reached = folder / "reached"
            reached.write_bytes(bytes(4096))
            self.said(program, TESSERA_FAULTS_REACHED=str(reached))
            self.assertEqual([n for n, byte in enumerate(reached.read_bytes()) if byte], [n for n, *_ in chosen])

    def test_leave_what_they_cannot_part(self):
        for line, operator, after in (("    if constexpr (n == 1)", "comparison", "    if constexpr (n != 1)"),
                                      ("#define A(x) f(x, 1)", "constant", "#define A(x) f(x, 0)")):
            text = f"// One.\n{line}\n"
            self.assertEqual(switched(text, [(1, 2, operator, after, "plain")]), (text, {}))
        shared = "// C++ and GLSL in one text.\nint f() { return 1; }\n"
        self.assertEqual(switched(shared, [(1, 2, "constant", "int f() { return 0; }", "plain")]), (shared, {}))

    def test_those_that_do_not_compile_are_found(self):
        build = object.__new__(SwitchedBuild)
        build.root = build.build = Path("/copy")
        build.manners, build.parts = dict.fromkeys(range(4), 0), {"a.h": {0: (3, 4), 1: (9, 9)}, "b.h": {2: (1, 1), 3: (5, 5)}}
        self.assertEqual(build.wrong("FAILED: x\nin a.h:9:\na.h:4:1: error: no\n"), {0})
        self.assertEqual(build.wrong("FAILED: x\nc.cpp:4:1: error: not constant\nb.h:5:2: note: here\nFAILED: y\na.h:9:1: error: no\n"), {1, 3})
        self.assertEqual(build.wrong("FAILED: x\na.h:7:1: error: no\n"), {0, 1}, "all of the file")
        self.assertEqual(build.wrong("FAILED: x\nc.cpp:7:1: error: no\n"), set())


class Tests:
    """Tests that fail with some faults, and how often they ran."""

    def __init__(self, **fails):
        self.fails, self.runs = fails, []

    def run(self, program, names, faults, timeout):
        self.runs.append((names, sorted(faults)))
        by = next((name for name in names if any(set(group) <= faults for group in self.fails[name])), "")
        return Tested(by, "", 1.0)

    def judged(self, reached, files=None, limit=0, jobs=1):
        """{fault: (verdict, by, tests met)} of faults that tests reach, {test: (faults, seconds)}."""
        faults = {n: {"file": (files or {}).get(n, "a.cpp")} for n in {n for of, _ in reached.values() for n in of} | {99}}
        learnt = {f"p {name}": {"seconds": seconds, "reached": of} for name, (of, seconds) in reached.items()}
        found = {}
        judge = Judge(self.run, learnt, faults, lambda n, *told: found.__setitem__(n, told), jobs)
        judge.judge(set(faults), limit)
        return found


class Judged(unittest.TestCase):
    def test_by_the_tests_that_reach_them(self):
        tests = Tests(one=[{1}, {2}], other=[{2}, {3}])
        found = tests.judged({"one": ([1, 3], 1), "other": ([1, 2, 3], 1)})
        self.assertEqual({n: told[:2] for n, told in found.items()},
                         {1: ("killed", "one"), 2: ("killed", "other"), 3: ("killed", "other"), 99: ("survived", "")})
        self.assertNotIn((["one"], [2]), tests.runs)
        self.assertEqual(found[99][2], 0)

    def test_survivors_have_met_all_and_most_at_once(self):
        names = [f"t{n}" for n in range(20)]
        tests = Tests(**{name: [{7}] if name == "t9" else [] for name in names})
        found = tests.judged({name: (list(range(32)), 20) for name in names}, jobs=2)
        self.assertEqual([n for n, told in found.items() if told[0] == "killed"], [7])
        self.assertEqual({told[2] for n, told in found.items() if n not in (7, 99)}, {20})
        self.assertLess(len(tests.runs), 32 + 20 + 3 * 10, "20 tests and 32 faults are 640")

    def test_faults_that_hide_one_another_survive(self):
        found = Tests(one=[{1, 2}]).judged({"one": ([1, 2], 1), "far": ([], 1)}, limit=-1)
        self.assertEqual({told[0] for told in found.values()}, {"survived"})

    def test_a_test_that_fails_now_and_then_kills_nobody(self):
        tests = Tests(one=[set()], other=[{1}])
        found = tests.judged({"one": ([1, 2], 1), "other": ([1, 2], 1)})
        self.assertEqual({n: told[:2] for n, told in found.items()}, {1: ("killed", "other"), 2: ("survived", ""), 99: ("survived", "")})

    def test_nearest_tests_first_then_short_ones(self):
        reached = {"wide": ([1, 2, 3], 10), "own": ([1], 10), "short": ([1, 2, 3], 0.1)}
        tests = Tests(wide=[], own=[], short=[])
        tests.judged(reached, {2: "b.cpp", 3: "b.cpp"}, limit=100)
        self.assertEqual([name for names, of in tests.runs if of == [1] for name in names], ["short", "own", "wide"])

    def test_join_short_ones_of_a_program(self):
        tests = [("p" if n % 2 else "q", str(n)) for n in range(100)]
        found = in_rounds(tests, {test: 1.0 for test in tests})
        self.assertEqual(sorted(name for _, names, _ in found for name in names), sorted(name for _, name in tests))
        self.assertLess(len(found), 12)
        self.assertEqual(found[0], ("q", ["0", "2", "4"], 3.0))
        self.assertEqual(sum(seconds for _, _, seconds in found), 100)


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

    def test_is_kept_between_runs(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "build" / "sample.jsonl"
            self.assertEqual(score.read(path), [])
            score.append(path, result("killed", 1))
            score.append(path, result("survived", 2))
            self.assertEqual(score.read(path), [result("killed", 1), result("survived", 2)])

    def test_switches_are_kept_for_the_same_sources(self):
        with tempfile.TemporaryDirectory() as folder:
            path, mutant = Path(folder) / "compiled", result("killed", 1)
            Manners(path, TEXTS).add(mutant, 2)
            self.assertEqual(Manners(path, TEXTS).found, {score.key(mutant): 2})
            self.assertEqual(Manners(path, {**TEXTS, "render/b.cpp": ["    x = 2;"]}).found, {})


if __name__ == "__main__":
    unittest.main()
