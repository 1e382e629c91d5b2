"""What a sample came to, kept as lines of JSON: one for each time that a mutant met tests."""
import json
import math
from pathlib import Path

EQUIVALENT = Path(__file__).resolve().parent / "equivalent.jsonl"  # mutants that change nothing, and why


def key(result):
    return result["file"], result["before"], result["after"]


def read(path):
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


def append(path, result):
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "a") as file:
        file.write(json.dumps(result) + "\n")


def judged(results, new_tests):
    """By mutant, what was found last, or last before tests were written for it; without those that do not build."""
    found = {}
    for result in results:
        if result["verdict"] != "no build" and (new_tests or not result["new_tests"]):
            found[key(result)] = result
    return found


def wilson(killed, of, z=1.959964):
    """The 95 % interval of a share. Source: Wilson 1927, probable inference."""
    if of == 0:
        return 0.0, 1.0
    share = killed / of
    middle = share + z * z / (2 * of)
    half = z * math.sqrt(share * (1 - share) / of + z * z / (4 * of * of))
    whole = 1 + z * z / of
    return max(0.0, (middle - half) / whole), min(1.0, (middle + half) / whole)


def told(results):
    """A share in words."""
    of, killed = len(results), sum(result["verdict"] == "killed" for result in results)
    low, high = wilson(killed, of)
    return f"{killed} of {of} killed, {100 * killed / max(of, 1):.0f} % (95 %: {100 * low:.0f} to {100 * high:.0f} %)"


def table(results, name):
    """The share killed by one of the keys of a result."""
    groups = {}
    for result in results:
        groups.setdefault(result[name], []).append(result["verdict"] == "killed")
    return [f"  {group:28} {sum(group_of):3} of {len(group_of):3}" for group, group_of in sorted(groups.items())]


def report(results, equivalent):
    """Text: the score, that without what is argued equivalent, that with tests written since, and the survivors."""
    first, last = judged(results, False), judged(results, True)
    argued = {key(entry): entry["because"] for entry in equivalent}
    real = [result for name, result in first.items() if name not in argued]
    unbuilt = len({key(result) for result in results} - set(first))
    text = [f"{told(first.values())}; {unbuilt} more did not build", *table(first.values(), "room"),
            *table(first.values(), "operator"), f"without {len(first) - len(real)} argued equivalent: {told(real)}"]
    if any(result["new_tests"] for result in results):
        text.append(f"with the tests written for survivors: {told([r for name, r in last.items() if name not in argued])}; "
                    "what those are worth elsewhere only another seed tells")
    for name, result in last.items():
        if result["verdict"] == "survived":
            said = (f"equivalent: {argued[name]}" if name in argued else
                    f"all {result['met']} tests that reach it pass" if result["whole"] else "not all tests have run")
            text += ["", f"{result['file']}:{result['line']}: {result['operator']}; {said}",
                     "- " + result["before"].strip(), "+ " + result["after"].strip()]
    return "\n".join(text)
