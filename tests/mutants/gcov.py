"""Which functions have run, by the notes (.gcno) and counters (.gcda) of gcc 12 and newer. gcov itself prints every line of
every source, which takes seconds for each test. Source of the format: gcc/gcov-io.h."""
import struct
from pathlib import Path

FUNCTION, LINES, COUNTERS = 0x01000000, 0x01450000, 0x01a10000


class Words:
    """A file's little-endian words and strings, one after the other."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def word(self):
        self.at += 4
        return struct.unpack_from("<I", self.data, self.at - 4)[0]

    def string(self):
        length = self.word()
        self.at += length
        return self.data[self.at - length:self.at].rstrip(b"\0").decode(errors="replace")

    def records(self):
        """(tag, length) of each record; the next one begins behind it, whatever of it was read."""
        while self.at + 8 <= len(self.data):
            tag, length = struct.unpack("<Ii", self.data[self.at:self.at + 8])
            if tag == 0:
                return
            self.at += 8
            behind = self.at + max(length, 0)  # a negative length: so many bytes of zeros, left out
            yield tag, length
            self.at = behind


def header(words, magic, path):
    if words.data[:4] != magic:
        raise ValueError(f"{path}: expected {magic.decode()} of gcov, found {words.data[:4]}")
    words.at = 16  # magic, version, stamp, checksum


def lines_of(path):
    """By identity of each function of an object's notes: its (source, first line, last line), its mangled name, and the
    (source, line) of its code, inlined code too. The compiler drops lines: what is computed before they run, or joined
    with others."""
    words, found, own = Words(Path(path).read_bytes()), {}, set()
    header(words, b"oncg", path)
    words.string()  # working directory
    words.word()  # whether blocks that cannot run are told
    for tag, length in words.records():
        if tag == FUNCTION:
            identity, _, _ = words.word(), words.word(), words.word()
            name, _ = words.string(), words.word()  # and whether the compiler made it
            source, first, _, last = words.string(), words.word(), words.word(), words.word()
            found[identity] = ((source, first, last), name, own := set())
        elif tag == LINES:
            end, source = words.at + length, ""
            words.word()  # block
            while words.at < end:
                if line := words.word():
                    own.add((source, line))
                else:
                    source = words.string()
    return found


def ran(path):
    """Identities of the functions of an object that have run."""
    words, found, of = Words(Path(path).read_bytes()), set(), 0
    header(words, b"adcg", path)
    for tag, length in words.records():
        if tag == FUNCTION:
            of = words.word() if length else 0
        elif tag == COUNTERS and length > 0 and any(words.data[words.at:words.at + length]):
            found.add(of)
    return found
