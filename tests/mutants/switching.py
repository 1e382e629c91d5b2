"""Faults behind switches: a source text in which each fault is there, and acts only where it is asked for when the program
runs. So one build holds all faults of a sample, and tells which tests reach them. By text alone: what does not compile is
tried in another manner (MANNERS), then planted by itself. Lines keep their numbers."""
import re

from operators import code_of

# How a fault is asked for. `plain`: by a call. `constant`: by a call, where a function is constexpr, which compilers may
# run. `inline`, `local`: a constant of a class or namespace, of a function, is computed when the program runs.
MANNERS = ("plain", "constant", "inline", "local")
DECLARED = 'extern "C" __attribute__((const)) bool tesseraFault(int) noexcept; '
OPENERS, CLOSERS = {")": "(", "]": "[", "}": "{"}, {"(": ")", "[": "]", "{": "}"}
ENDS = re.compile(r"\b(return|else|throw|case|delete|co_return|do)$")
BLOCKS = re.compile(r"(\b(const|noexcept|override|else|do|try|final)|[);{}:,]|->.*)$")
BRANCHES = re.compile(r"\b(if|while|for|switch|constexpr|catch)$")


class Unswitchable(Exception):
    """A fault that has no expression or statement of its own."""


class Code:
    """A file's text, and the same without comments and what is in quotes."""

    def __init__(self, text):
        self.text = text
        self.lines = text.split("\n")
        self.code = "\n".join(code_of(line) for line in self.lines)
        self.begins = [0]
        for line in self.lines:
            self.begins.append(self.begins[-1] + len(line) + 1)

    def without_comments(self, begin, end):
        """A part of the text on one line."""
        out = []
        for n, line in enumerate(self.lines):
            a, b = max(begin - self.begins[n], 0), min(end - self.begins[n], len(line))
            if a <= b and self.begins[n] <= end and self.begins[n + 1] > begin:
                out.append(line[a:min(b, comment_of(line))])
        return " ".join(out)

    def opener(self, at):
        """Place of the bracket that the one at `at` closes."""
        depth = 0
        for i in range(at, -1, -1):
            depth += (self.code[i] in OPENERS) - (self.code[i] in CLOSERS)
            if depth == 0:
                return i
        raise Unswitchable

    def around(self, at):
        """Place of the innermost bracket that is open before `at`."""
        depth = 0
        for i in range(at - 1, -1, -1):
            depth += (self.code[i] in OPENERS) - (self.code[i] in CLOSERS)
            if depth < 0:
                return i
        raise Unswitchable

    def closer(self, at):
        depth = 0
        for i in range(at, len(self.code)):
            depth += (self.code[i] in CLOSERS) - (self.code[i] in OPENERS)
            if depth == 0:
                return i
        raise Unswitchable

    def is_block(self, at):
        """Whether the brace at `at` opens a block, not a list of values."""
        return bool(BLOCKS.search(self.code[:at].rstrip()[-80:].split("\n")[-1]))

    def assigns(self, at):
        """Length of the assignment whose = is at `at`; 0 where that compares."""
        before, after = self.code[at - 1], self.code[at + 1]
        if after == "=" or before in "=!<>":
            return 0
        return 2 if before in "+-*/%&|^" else 1

    def colon(self, at):
        return self.code[at] == ":" and self.code[at - 1] != ":" and self.code[at + 1] != ":"

    def left(self, at):
        """Where the expression that holds what is before `at` begins."""
        i = at - 1
        while i >= 0:
            c = self.code[i]
            if c in CLOSERS or c in ",;?" or self.colon(i) or (c == "=" and self.assigns(i)):
                return i + 1
            if c in OPENERS:
                opener = self.opener(i)
                if (c == "}" and self.is_block(opener)) or (c == ")" and BRANCHES.search(self.code[:opener].rstrip()[-12:])):
                    return i + 1
                i = opener
            elif c.isspace() and ENDS.search(self.code[:i + 1].rstrip()[-12:]):
                return i + 1
            i -= 1
        return 0

    def right(self, at):
        """Where the expression ends that goes on at `at`."""
        i = at
        while i < len(self.code):
            c = self.code[i]
            if c in OPENERS or c in ",;?" or self.colon(i) or (c == "{" and self.is_block(i)):
                return i
            if c == "=" and (length := self.assigns(i)):
                return i - length + 1
            i = self.closer(i) + 1 if c in CLOSERS else i + 1
        return i

    def balanced(self, begin, end):
        """The part with the brackets that its own need."""
        open_, i = [], begin
        while i < end or open_:
            if self.code[i] in CLOSERS:
                open_.append(i)
            elif self.code[i] in OPENERS:
                if open_:
                    open_.pop()
                else:
                    begin = self.opener(i)
            i += 1
            if i >= len(self.code):
                raise Unswitchable
        return begin, max(i, end)

    def has_comma(self, begin, end):
        depth = 0
        for c in self.code[begin:end]:
            depth += (c in CLOSERS) - (c in OPENERS)
            if c == "," and depth == 0:
                return True
        return False


def comment_of(line):
    """Place of a line's comment, or its length."""
    code = code_of(line)
    for i in range(len(line) - 1):
        if line[i:i + 2] == "//" and code[i:i + 2] == "  " and (i == 0 or not quoted(line, i)):
            return i
    return len(line)


def quoted(line, at):
    return len(re.findall(r'(?<!\\)"', line[:at])) % 2 == 1


def statement(code, line, after, asked):
    """A statement that is left out, or before which its function returns."""
    begin = code.begins[line] + len(code.lines[line]) - len(code.lines[line].lstrip())
    end = code.begins[line] + len(code_of(code.lines[line]).rstrip())
    before = f"{{ if ({asked}) {after.strip()} " if after.strip() != "{}" else f"{{ if (!{asked}) {{ "
    return begin, end, before, " }" if after.strip() != "{}" else " } }"


def expression(code, line, after, asked):
    """The least expression that holds what differs, there as it is and with the fault."""
    old, start = code.lines[line], code.begins[line]
    same = next(i for i in range(len(old) + 1) if old[:i + 1] != after[:i + 1])
    rest = 0
    while rest < min(len(old), len(after)) - same and old[-1 - rest] == after[-1 - rest]:
        rest += 1
    begin, end = first, last = start + same, start + len(old) - rest
    changed = after[same:len(after) - rest]
    begin, end = code.balanced(begin, end)
    while code.code[end:end + 1] == "=" and code.code[end + 1] != "=" and code.code[end - 1] in "+-":  # += for -=
        end += 1
    if begin > 0 and code.code[begin:begin + 2] in ("+=", "-="):
        end = max(end, begin + 2)
    begin, end = code.left(begin), code.right(end)
    while code.has_comma(begin, end):
        opener = code.around(begin)
        begin, end = code.left(opener), code.right(code.closer(opener) + 1)
    while code.code[begin].isspace():
        begin += 1
    while code.code[end - 1].isspace():
        end -= 1
    if begin > first or end < last or "\n#" in code.code[begin:end] or re.search(r"constexpr\s*\($", code.code[:begin]):
        raise Unswitchable
    fault = code.without_comments(begin, first) + changed + code.without_comments(last, end)
    return begin, end, f"({asked} ? ({fault}) : (", "))"


def declaration(code, begin, manner):
    """The change of the word constexpr of the statement that holds `begin`; None where that has none."""
    at = max(code.code.rfind(c, 0, begin) for c in ";{}") + 1
    m = None
    while at >= 0:  # braces of a list of values belong to the statement
        m = re.search(r"\bconstexpr\b(?!\s*\()", code.code[at:begin])
        if m or at == 0 or code.code[at - 1] != "{" or code.is_block(at - 1):
            break
        at = max(code.code.rfind(c, 0, at - 1) for c in ";{}") + 1
    return None if not m else (at + m.start(), at + m.end(), "inline const" if manner == "inline" else "const")


def negated(code, line, after, asked):
    """A condition that is turned round."""
    begin, end, before, behind = expression(code, line, after, asked)
    return begin, end, f"({asked} != static_cast<bool>(", "))"


def placed(code, line, operator, after, number, manner):
    """(begin, end, before, behind) of a fault, and the change of its declaration. `line` counts from 0."""
    if "embedded" in code.lines[0] or re.search(r"C\+\+\s+(//\s+)?and\s+(//\s+)?GLSL", code.text[:1000]):
        raise Unswitchable  # shaders read it too
    if any(text.endswith("\\") for text in code.lines[max(line - 1, 0):line + 1]) or code.lines[line].lstrip().startswith("#"):
        raise Unswitchable  # a macro
    call = f"tesseraFault({number})"
    asked = f"(!__builtin_is_constant_evaluated() && {call})" if manner == "constant" else call
    kind = {"early return": statement, "dropped statement": statement, "negated condition": negated}.get(operator, expression)
    part = kind(code, line, after, asked)
    change = declaration(code, part[0], manner)
    if (change is not None) != (manner in ("inline", "local")):
        raise Unswitchable
    return part, change


def switched(text, faults):
    """The text with faults behind switches, and the lines that each takes. `faults`: (number, line, operator, after,
    manner), where `line` counts from 1. Faults that have no place, or cross another, are left out."""
    code, parts, changes = Code(text), {}, set()
    for number, line, operator, after, manner in faults:
        try:
            part, change = placed(code, line - 1, operator, after, number, manner)
        except (Unswitchable, IndexError, StopIteration):
            continue
        if any(a < part[0] < b < part[1] or part[0] < a < part[1] < b for a, b, _, _ in parts.values()):
            continue
        parts[number] = part
        changes |= {change} if change else set()
    inserted = []  # (place, order, text): what ends goes before what begins, inner ends first, outer begins first
    for begin, end, before, behind in parts.values():
        inserted += [(begin, 1, -end, before), (end, 0, -begin, behind)]
    out, at = [], 0
    edits = [(place, order, size, place, piece) for place, order, size, piece in inserted]
    edits += [(begin, 2, 0, end, piece) for begin, end, piece in changes]
    for place, _, _, end, piece in sorted(edits):
        out += [text[at:place], piece]
        at = end
    lines = "".join(out + [text[at:]]).split("\n")
    if parts:
        first = next((n for n, line in enumerate(lines) if not line.strip() or line.startswith("//")), None)
        if first is None or any(code.begins[first] > begin for begin, _, _, _ in parts.values()):
            return text, {}
        lines[first] = DECLARED + lines[first]
    return "\n".join(lines), {number: (code.code.count("\n", 0, begin) + 1, code.code.count("\n", 0, end) + 1)
                              for number, (begin, end, _, _) in parts.items()}
