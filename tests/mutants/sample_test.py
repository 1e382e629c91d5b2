#!/usr/bin/env python3
"""What sample.py draws: by the operators, the same for a seed, such as planted() can plant; and what score.py tells."""
import os
import subprocess
import sys
import tempfile
import unittest
from itertools import islice
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import gcov
import score
from operators import OPERATORS, faults_of
from planting import planted
from sample import draws, room_of, unbuilt

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
