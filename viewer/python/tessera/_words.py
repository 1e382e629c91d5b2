"""Arguments of Python as words of a command line, so that both have the same names, checks and messages."""

from __future__ import annotations

import operator
import os
import sys
from typing import TYPE_CHECKING, Any, Callable, Iterable, List, Mapping, Optional, Sequence, Union

from . import _tessera
from ._tessera import InputError

Progress = Union[None, bool, Callable[[str, float], Any]]
Path = Union[str, "os.PathLike[str]"]
if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array = NDArray[Any]
    Numbers = Union[Sequence[float], Array]


def absolute(path: Any) -> str:
    """A path that means the same in any folder; an address stays as it is."""
    text = os.fsdecode(path)
    return text if "://" in text else os.path.abspath(text)


def number(value: Any, name: str) -> float:
    """An argument that is a number, of numpy too."""
    try:
        if not isinstance(value, (str, bytes)):
            return float(value)
    except (TypeError, ValueError):
        pass
    raise InputError(f"{name}: expected a number, found {repr(value)[:80]}")


def whole_number(value: Any, name: str, low: int, high: int) -> int:
    """An argument that is a whole number within bounds."""
    try:
        at = operator.index(value)
    except TypeError:
        raise InputError(f"{name}: expected a whole number, found {repr(value)[:80]}") from None
    if not low <= at <= high:
        raise InputError(f"{name}: expected {low} to {high}, found {at}")
    return at


def told(progress: Any) -> Optional[Callable[[str, float], Any]]:
    """The progress function of a call; True: a line on stderr that is written again and again."""
    if progress is None or progress is False:
        return None
    if progress is not True:
        return progress  # type: ignore[no-any-return]

    def write(stage: str, share: float) -> None:
        sys.stderr.write(f"\r\033[K{stage}: {share:.0%}" if share < 1 else "\r\033[K")
        sys.stderr.flush()

    return write


def text_of(value: Any, option: str) -> str:
    """The text of an option's value: numbers joined by commas, paths as they are."""
    if isinstance(value, str):
        return value
    if isinstance(value, bytes):
        return os.fsdecode(value)
    if hasattr(value, "__fspath__"):
        return str(os.fspath(value))
    if hasattr(value, "item") and getattr(value, "ndim", 0) == 0:
        value = value.item()  # a number of numpy
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, Iterable) and not isinstance(value, Mapping):
        return ("x" if option == "size" else ",").join(text_of(one, "") for one in value)
    raise InputError(f"{option}: expected text, a number or a sequence of numbers, found {type(value).__name__}")


def words_of(options: Mapping[str, Any]) -> List[str]:
    """max_error=1 is "--max-error=1"; True is a flag; None and False are left out; of a list each item is one."""
    words = []
    for name, value in options.items():
        option = name.replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            words.append(f"--{option}")
            continue
        for one in value if isinstance(value, list) else [value]:
            words.append(f"--{option}={text_of(one, name)}")
    return words


def arguments_of(options: Iterable[str]) -> List[str]:
    """Options of the command line as arguments: "--max-error" is max_error."""
    return [option[2:].replace("-", "_") for option in options if option != "--help"]


def refuse_unknown(given: Iterable[str], known: Sequence[str], function: str) -> None:
    """Refuses arguments that a function does not have, with the nearest that it has."""
    for name in given:
        if name not in known:
            likely = _tessera.likely_option(f"--{name}", [f"--{one.replace('_', '-')}" for one in known])
            near = f"; nearest: {arguments_of([likely])[0]}" if likely else ""
            raise InputError(f"{name}: expected an argument of {function}, found an unknown one{near}")


def ram_text(ram: Any) -> str:
    """A budget as text: "512MiB", or bytes as a number; None: by default."""
    return "" if ram is None else text_of(ram, "ram")
