"""Commands that run in process groups of their own and take no more than they may. Their groups end with this program:
where it is interrupted or terminated whole, where it is killed the processes that it started itself."""
import ctypes
import os
import resource
import select
import signal
import subprocess
import tempfile
import threading
import time
from pathlib import Path
from typing import NamedTuple

TEXT_BYTES = 16 << 20  # of a command's output, its end, are kept
DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG
LIBC = ctypes.CDLL(None)
stopping = threading.Event()  # set where this program is to end: commands end, and nothing is known of them


class Stopped(Exception):
    """A command ended because this program does."""


class Ended(NamedTuple):
    status: int  # as subprocess has it; None where a limit of time was met
    text: str  # standard output and errors
    seconds: float  # of processors, with those of all that it started and waited for


class Limits(NamedTuple):
    """What a command may take; None: as much as it likes."""
    clock: float = None  # seconds
    idle: float = None  # seconds by the clock in which none of its session takes any of a processor
    processor: float = None  # seconds, of each process
    memory: int = None  # bytes of address space, of each process
    file: int = None  # bytes of a file that it writes

    def set(self):
        LIBC.prctl(DEATH_SIGNAL, signal.SIGKILL)
        seconds = None if self.processor is None else int(self.processor) + 1
        for kind, most in ((resource.RLIMIT_AS, self.memory), (resource.RLIMIT_CPU, seconds), (resource.RLIMIT_FSIZE, self.file)):
            if most is not None:
                hard = resource.getrlimit(kind)[1]
                resource.setrlimit(kind, (most, hard))


def stop_on_signals():
    """Who interrupts or ends this program ends its commands: KeyboardInterrupt in the main thread, Stopped in others."""
    def stop(number, frame):
        stopping.set()
        raise KeyboardInterrupt
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):  # a shell's background jobs ignore the first
        signal.signal(number, stop)


def taken(session):
    """Ticks of processors that a session's processes have taken, and those of their children that ended."""
    ticks = 0
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()  # from the state on: man 5 proc
        except OSError:
            continue
        if int(fields[3]) == session:
            ticks += sum(map(int, fields[11:15]))
    return ticks


def ended(leader, ending, limits):
    """Waits for a leader and ends its group; whether it came to its own end. Who is asked to end can remove what is half
    written, as compilers do."""
    def wait(seconds):
        return bool(select.select([ending], [], [], seconds)[0])
    try:
        begun = worked = time.time()
        ticks = 0
        while not (own := wait(0.5)) and not stopping.is_set():
            now = time.time()
            if limits.idle is not None and (by := taken(leader)) != ticks:
                ticks, worked = by, now
            if (limits.clock is not None and now - begun > limits.clock) or \
                    (limits.idle is not None and now - worked > limits.idle):
                break
        return own
    finally:
        if not wait(0):
            os.killpg(leader, signal.SIGTERM)
            wait(2)
        os.killpg(leader, signal.SIGKILL)  # nobody has waited for the leader yet: the number is its own


def run(command, folder, env, limits=Limits()):
    """Runs a command to its end or its limits."""
    if stopping.is_set():
        raise Stopped
    with tempfile.TemporaryFile() as output:
        process = subprocess.Popen([str(word) for word in command], cwd=folder, env=env, stdin=subprocess.DEVNULL,
                                   stdout=output, stderr=subprocess.STDOUT, start_new_session=True, preexec_fn=limits.set)
        ending = os.pidfd_open(process.pid)
        try:
            own = ended(process.pid, ending, limits)
        finally:
            _, status, used = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)  # Popen need not wait any more
            os.close(ending)
        if stopping.is_set():
            raise Stopped
        output.seek(max(0, output.seek(0, os.SEEK_END) - TEXT_BYTES))
        hangs = not own or process.returncode == -signal.SIGXCPU
        return Ended(None if hangs else process.returncode, output.read().decode(errors="replace"),
                     used.ru_utime + used.ru_stime)
