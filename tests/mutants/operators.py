"""Small faults of a line of C++, by text alone: what sample.py draws from. What does not compile is drawn again."""
import re

WORD = r"[A-Za-z_]\w*"
CALL = re.compile(rf"\b(?:std|glm)::(min|max|clamp)\(")
SYMMETRIC = r"(?:min|max|dot|distance)\("  # whose arguments may change places
PARAMETER = re.compile(r"^const\b|[\w>&*] [&*]?[A-Za-z_]\w*$|[&*]$")  # of a declaration
SKIPPED = re.compile(r"^\s*(//|#|\*|\}|using |namespace |template|class |struct |enum |public:|private:|case .*:$|"
                     r"static_assert|TESSERA_CHECK|throw |friend |typedef )|\.reserve\(")


def code_of(line):
    """The line with what is in quotes, and what follows //, blanked: places stay."""
    blank = re.sub(r'"(\\.|[^"\\])*"|\'(\\.|[^\'\\])\'',
                   lambda m: m.group(0)[0] + " " * (len(m.group(0)) - 2) + m.group(0)[-1], line)
    return re.sub(r"//.*", lambda m: " " * len(m.group(0)), blank)


def replaced(line, match, text):
    return line[:match.start()] + text + line[match.end():]


def arguments_of(code, begin):
    """Places (from, to) of the arguments of a call whose parenthesis opens before `begin`; none where it goes on."""
    depth, at, places = 0, begin, []
    for i in range(begin, len(code)):
        if code[i] in "([{":
            depth += 1
        elif code[i] in ")]}":
            depth -= 1
            if depth < 0:
                return places + [(at, i)]
        elif code[i] == "," and depth == 0:
            places.append((at, i))
            at = i + 1
    return []


def exchange(pattern, table):
    def of(line, code):
        return [replaced(line, m, m.group(0).replace(m.group(1), table[m.group(1)]))
                for m in re.finditer(pattern, code) if m.group(1) in table]
    return of


def off_by_one(line, code):
    dropped = [replaced(line, m, "") for m in re.finditer(r" [+-] 1\b(?![.\w])", code)]
    more = [replaced(line, m, m.group(0) + " + 1") for m in re.finditer(rf"\[{WORD}(?=\])", code)]
    return dropped + more


def dropped_clamp(line, code):
    out = []
    for m in CALL.finditer(code):
        if len(places := arguments_of(code, m.end())) >= 2:
            for begin, end in places[:1] if m.group(1) == "clamp" else places:
                out.append(line[:m.start()] + "(" + line[begin:end].strip() + ")" + line[places[-1][1] + 1:])
    return out


def swapped_arguments(line, code):
    out = []
    for m in re.finditer(rf"\b(?!{SYMMETRIC}){WORD}\(", code):
        places = arguments_of(code, m.end())
        for (a, b), (c, d) in zip(places, places[1:]):
            first, second = line[a:b].strip(), line[c:d].strip()
            if first and second and first != second and not PARAMETER.search(first) and not PARAMETER.search(second):
                out.append(line[:a] + (" " if line[a] == " " else "") + second + ", " + first + line[d:])
    return out


def constant(line, code):
    def other(text):
        return "1" + text[1:] if float(text.rstrip("f")) == 0 else "0" if text == "1" else f"(2 * {text})"
    number = r"(?<![\w.'])\d+(\.\d+)?(e-?\d+)?f?(?![\w.'])"
    return [replaced(line, m, other(m.group(0))) for m in re.finditer(number, code)]


def early_return(line, code):
    m = re.match(r"(\s*)return (?!(?:\{\}|nullptr|false|0|std::nullopt|\"\");)[^;]+;$", code.rstrip())
    if m:
        return [m.group(1) + "return {};"]
    # of a function without a value
    m = re.match(rf"(\s*)(?!return|break|continue|else){WORD}[\w.:>\-]*\(.*\);$", code.rstrip())
    return [m.group(1) + "return;"] if m else []


def negated(line, code):
    out = []
    for m in re.finditer(r"\b(if|while) \(", code):
        if len(places := arguments_of(code, m.end())) == 1 and ";" not in code[m.end():places[0][1]]:
            begin, end = places[0]
            out.append(line[:begin] + "!(" + line[begin:end] + ")" + line[end:])
    return out


def dropped_statement(line, code):
    kept = "return|break|continue|else|using|const|auto|delete|goto"
    m = re.match(rf"(\s*)(?!{kept})({WORD}[\w.:>\[\]()\-]*(\(.*\)| [-+*/|&^]?= .*)|\+\+.*|--.*);$", code.rstrip())
    return [m.group(1) + "{}"] if m else []


def axis(line, code):
    turn = {"x": "y", "y": "z", "z": "x"}
    return [replaced(line, m, "." + turn[m.group(1)]) for m in re.finditer(r"\.([xyz])\b(?!\()", code)]


def unit_factor(line, code):
    return [replaced(line, m, "") for m in re.finditer(rf" [*/] [\w.:]+\b(?![(\[\w.:'<])", code)]


OPERATORS = {
    "comparison": exchange(r" (<=?|>=?|==|!=) ", {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "=="}),
    "sign": exchange(r" ([+-]=?) ", {"+": "-", "-": "+", "+=": "-=", "-=": "+="}),
    "logic": exchange(r" (&&|\|\|) ", {"&&": "||", "||": "&&"}),
    "off by one": off_by_one,
    "dropped clamp": dropped_clamp,
    "swapped arguments": swapped_arguments,
    "constant": constant,
    "early return": early_return,
    "negated condition": negated,
    "dropped statement": dropped_statement,
    "axis": axis,
    "unit factor": unit_factor,
}


def faults_of(line):
    """All faults of a line: (operator, the line with it)."""
    code = code_of(line)
    if SKIPPED.search(line) or not code.strip() or line.startswith("}"):
        return []
    return [(name, fault) for name, operator in OPERATORS.items() for fault in dict.fromkeys(operator(line, code))
            if fault != line]
