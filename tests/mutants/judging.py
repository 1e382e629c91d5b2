"""Which faults of a build with switches the tests kill. Each meets first the tests that meet it most likely in a second, by
itself. Those that live meet all others that reach them, many at once: where a test passes with all of them, each passes it;
where it fails, halves tell who fails it."""
import threading
from concurrent.futures import ThreadPoolExecutor

START_SECONDS = 0.5  # to start a test
FIRST_SECONDS, MORE = 4.0, 3  # of the first tests, and how much longer later ones may run together


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


def time_for(seconds):
    """What tests may take of a processor that take so much without a fault."""
    return 30 + 10 * seconds


class Judge:
    """`run(program, names, faults, timeout)`: tests with faults. `tests`: what a build has learnt. `faults`: {number:
    mutant}. `told(number, verdict, by, met)` takes what was found, `met` tests."""

    def __init__(self, run, tests, faults, told, jobs):
        self.run_, self.faults, self.told, self.jobs = run, faults, told, jobs
        self.tests = {tuple(name.split(" ", 1)): of for name, of in tests.items()}
        self.reached = {n: [test for test, of in self.tests.items() if n in of["reached"]] for n in faults}
        self.alive, self.met, self.one = set(), {n: set() for n in faults}, threading.Lock()

    def cost(self, test):
        return START_SECONDS + self.tests[test]["seconds"]

    def likely(self, test, n):
        """Share of a fault's file among the faults that a test reaches: how likely the test is about that file."""
        own = self.tests[test]["reached"]
        same = sum(1 for other in own if other in self.faults and self.faults[other]["file"] == self.faults[n]["file"])
        return (same + 1) / (len(own) + 1)

    def run(self, program, names, faults):
        return self.run_(program, names, faults, time_for(sum(self.cost((program, name)) for name in names)))

    def found(self, n, by, program, names):
        """A kill, if the test fails again with the fault and passes without: others fail now and then."""
        name = by.split(": ")[0]
        if name in names and not by.endswith(": hangs") and \
                (not self.run(program, [name], {n}).by or self.run(program, [name], set()).by):
            return
        with self.one:
            if n in self.alive:
                self.alive.discard(n)
                self.told(n, "killed", by, len(self.met[n]))

    def alone(self, n, limit):
        """A fault and the tests that are nearest, until they have taken `limit` seconds."""
        order = sorted(self.reached[n], key=lambda test: -self.likely(test, n) / self.cost(test))
        used = 0
        for program, names, _ in in_rounds(order, {test: self.cost(test) for test in order}):
            if used > limit:
                return
            done = self.run(program, names, {n})
            used += done.seconds
            if done.by:
                self.found(n, done.by, program, names)
                if n not in self.alive:
                    return
            else:
                self.met[n] |= {(program, name) for name in names}

    def together(self, test):
        """A test and all faults that live and have not met it."""
        with self.one:
            group = sorted(n for n in self.alive if test in self.reached[n] and test not in self.met[n])
        if group:
            self.halves(test, group)
        for n in group:
            self.met[n].add(test)

    def halves(self, test, group):
        """Who of a group fails a test. A group that fails while both halves pass, has none."""
        if not (by := self.run(test[0], [test[1]], set(group)).by):
            return
        if len(group) == 1:
            return self.found(group[0], by, test[0], [test[1]])
        self.halves(test, group[:len(group) // 2])
        self.halves(test, group[len(group) // 2:])

    def judge(self, some, limit):
        """Judges some of the faults; `limit`: seconds for each by itself."""
        self.alive = set(some)
        with ThreadPoolExecutor(self.jobs) as threads:
            list(threads.map(lambda n: self.alone(n, limit), sorted(some)))
            order = sorted({test for n in self.alive for test in self.reached[n]}, key=lambda test: (self.cost(test), test))
            list(threads.map(self.together, order))
        for n in sorted(self.alive):
            self.told(n, "survived", "", len(self.met[n]))
