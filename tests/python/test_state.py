"""What Python's package leaves of the interpreter as it was: signals, output, folders; and how soon it is there."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest

LONG = "tessera.render(v, size=(2000, 2000), light='cinematic', samples=4096, engine='native', no_check=True)"
BEGIN = "import tessera, numpy as np\nv = tessera.phantom('torso', (64, 48, 75))\nprint('ready', flush=True)\n"

# Works that would take longer than half a minute, stopped by a signal, and how long that takes.
STOPPED = """
import json, os, signal, threading, time
import numpy as np, tessera
z, y, x = np.ogrid[:160, :160, :160]
middle = 80 + 30 * np.sin(z / 25)
values = np.where(np.hypot(x - middle, y - 80) < 14, -950, 40).astype(np.int16)
values[:6] = values[-6:] = 40
values = values + np.random.default_rng(1).integers(-20, 20, values.shape, dtype=np.int16)
volume = tessera.open(values, unit="HU")
os.chdir(os.environ["TMPDIR"])
many = np.broadcast_to(values[80], (200000, 160, 160))  # as if it were larger than memory
slow = np.broadcast_to(values[80].astype(np.float64).T, (200000, 160, 160))
draw = dict(size=(2000, 1600), engine="native", samples=1024, no_check=True)
works = {
    "open": lambda: tessera.open(many, unit="HU"),
    "open float64": lambda: tessera.open(slow),
    "phantom": lambda: tessera.phantom("torso", (1200, 1000, 1200)),
    "render": lambda: tessera.render(volume, **draw),
    "mip": lambda: tessera.render(volume, mode="mip", **draw),
    "isosurface": lambda: tessera.render(volume, mode="isosurface", isosurface="-400", **draw),
    "cinematic": lambda: tessera.render(volume, light="cinematic", **draw),
    "film": lambda: tessera.film(volume, "turn", turn=360, frames=2000, **draw),
}
found = []
for name, work in works.items():
    for delay in (0.1, 0.5):
        at = []
        def stop():
            time.sleep(delay)
            at.extend([time.monotonic(), time.process_time()])
            os.kill(os.getpid(), signal.SIGINT)
        thread = threading.Thread(target=stop)
        try:
            thread.start()
            work()
            raise SystemExit(name + ": done before it was stopped")
        except KeyboardInterrupt:
            found.append((name, time.monotonic() - at[0], time.process_time() - at[1]))
        thread.join()
print(json.dumps(found))
"""


def run(program, **more):
    return subprocess.run(
        [sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more
    )


class State(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.env = {**os.environ, "TMPDIR": self.folder.name, "XDG_CACHE_HOME": self.folder.name + "/cache"}

    def left(self):
        return [name for name in os.listdir(self.folder.name) if name != "cache"]

    def begin(self, program):
        process = subprocess.Popen(
            [sys.executable, "-c", BEGIN + program],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=self.env,
        )
        self.assertEqual(process.stdout.readline(), "ready\n")
        time.sleep(0.7)
        return process

    def test_ctrl_c_leaves_nothing_behind(self):
        process = self.begin(f"try:\n    {LONG}\nexcept KeyboardInterrupt:\n    print('stopped')\n")
        process.send_signal(signal.SIGINT)
        out, errors = process.communicate(timeout=30)
        self.assertEqual((out, errors, process.returncode), ("stopped\n", "", 0))
        self.assertEqual(self.left(), [])

    def test_ctrl_c_stops_any_work_within_a_second(self):
        found = json.loads(subprocess.check_output([sys.executable, "-c", STOPPED], env=self.env, timeout=200))
        self.assertEqual(len(found), 16)
        for name, wall, cpu in found:
            with self.subTest(name):
                # Others may have the processors meanwhile: what is calculated after the signal counts, on two of them,
                # and a wait.
                self.assertLess(cpu, 2, "CPU seconds after the signal")
                self.assertLess(wall, 4, "seconds after the signal, on a machine that is busy")

    def test_a_handler_of_the_users_may_raise(self):
        process = self.begin(
            "import signal\ndef stop(*_):\n    raise TimeoutError\nsignal.signal(signal.SIGALRM, stop)\n"
            f"signal.setitimer(signal.ITIMER_REAL, 0.3)\ntry:\n    {LONG}\nexcept TimeoutError:\n    print('late')\n"
        )
        out, _ = process.communicate(timeout=30)
        self.assertEqual(out, "late\n")

    def test_the_next_process_removes_what_a_killed_one_left(self):
        process = self.begin(LONG)
        process.kill()
        process.communicate()
        self.assertNotEqual(self.left(), [])
        self.assertEqual(run(BEGIN, env=self.env).returncode, 0)
        self.assertEqual(self.left(), [])

    def test_nothing_is_printed_and_nothing_changes(self):
        program = (
            "import os, signal, threading, locale, sys\n"
            "def state():\n"
            "    mask = os.umask(0); os.umask(mask)\n"
            "    return ([signal.getsignal(n) for n in signal.valid_signals()], mask, os.getcwd(), locale.setlocale(locale.LC_ALL),\n"
            "            threading.active_count(), sys.getdlopenflags(), dict(os.environ))\n"
            "def dispositions():\n"
            "    with open('/proc/self/status') as file:\n"
            "        lines = dict(line.split(':\\t') for line in file if line.startswith('Sig'))\n"
            "    ofThreads = 3 << 31  # glibc catches 32 and 33 once there are threads\n"
            "    return [int(lines[key], 16) & ~ofThreads for key in ('SigBlk', 'SigIgn', 'SigCgt')]\n"
            "import numpy\n"
            "before, signals = state(), dispositions()\n"
            "import tessera\n"
            "v = tessera.phantom('torso', (32, 24, 38))\n"
            "p = tessera.render(v, size=(32, 24), engine='native')\n"
            "p.save('a.png')\n"
            "try:\n    tessera.render(v, view='sideways')\nexcept tessera.InputError:\n    pass\n"
            "try:\n    tessera.render(v, isosurface='9000', mode='isosurface', size=(32, 24))\nexcept tessera.Error:\n    pass\n"
            "try:\n    tessera.open('/no/such/place')\nexcept ValueError:\n    pass\n"
            "after = state()\n"
            "assert after == before, [pair for pair in zip(after, before) if pair[0] != pair[1]]\n"
            "assert dispositions() == signals\n"
        )
        done = run(program, env=self.env, cwd=self.folder.name)
        self.assertEqual((done.stdout, done.stderr, done.returncode), ("", "", 0))

    def test_a_line_of_progress_is_written_only_where_it_is_asked_for(self):
        program = "import tessera\nv = tessera.phantom('torso', (32, 24, 38))\n{}"
        draw = "tessera.render(v, size=(200, 200), engine='native', progress={})"
        self.assertEqual(run(program.format(draw.format("None")), env=self.env).stderr, "")
        self.assertTrue(run(program.format(draw.format("True")), env=self.env).stderr.endswith("\033[K"))  # text mode has other ends of lines

    def test_it_is_imported_soon(self):
        program = (
            "import numpy, time, resource\n"
            "def used():\n    u = resource.getrusage(resource.RUSAGE_SELF)\n    return u.ru_utime + u.ru_stime\n"
            "a = used()\nimport tessera\nprint(used() - a)\n"
        )
        seconds = min(float(run(program).stdout) for _ in range(3))
        self.assertLess(seconds, 0.3, "of processor time, beside numpy")

    def test_importing_files_needs_no_flags_of_the_caller(self):
        # Modules find the program's symbols in the extension, however it was loaded.
        program = (
            "import tessera, tempfile, os, sys\n"
            "with tempfile.TemporaryDirectory() as f:\n"
            "    open(f + '/a.nii', 'wb').write(b'x' * 400)\n"
            "    try:\n        tessera.open(f + '/a.nii')\n"
            "    except tessera.InputError as e:\n        print('InputError')\n"
        )
        self.assertEqual(run(program, env=self.env).stdout, "InputError\n")


if __name__ == "__main__":
    unittest.main()
