"""Output of the command line: answers on standard output, everything else on standard error."""

import json
import math
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console


@cache
def notes() -> "Console":
    """Return the console for messages and progress on standard error; standard output has only answers."""
    from rich.console import Console

    return Console(stderr=True, highlight=False, emoji=False)


@cache
def answers() -> "Console":
    """Return the console for the tables and sentences of answers, on standard output."""
    from rich.console import Console

    return Console(highlight=False, emoji=False)


def print_json(document: object) -> None:
    """Print one JSON document. Floats are written with enough digits to read back the same bits; NaN becomes null."""
    from damperlab.service.documents import plain

    sys.stdout.write(json.dumps(plain(document), indent=2, ensure_ascii=False, allow_nan=False) + "\n")


def note(text: str) -> None:
    """Print a message on standard error. The console interprets no markup, and inserts no line breaks."""
    notes().print(text, markup=False, soft_wrap=True)


def say(text: str) -> None:
    """Print an answer in words on standard output."""
    answers().print(text, markup=False, soft_wrap=True)


def print_brief(brief: Mapping[str, Any], details: Iterable[str], wanted: bool, folder: str = "") -> None:
    """Print a short answer, and the sentences with details if the user wants details.

    `folder`, the option for the data folder, is appended to the command that the answer suggests.
    """
    from damperlab.studies.brief import lines_of

    for line in lines_of(brief):
        say(line + folder if line.startswith("Next: damperlab ") else line)
    if not wanted:
        say("Details: --details.")
        return
    say("")
    for sentence in details:
        say(sentence)


def print_table(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print a table with numbers aligned to the right. If the output is piped, no cell is cut to fit a terminal."""
    from rich.console import Console
    from rich.table import Table

    table = Table(header_style="bold", box=None, pad_edge=False)
    cells = [tuple(row) for row in rows]
    for index, column in enumerate(columns):
        numeric = all(_is_number(row[index]) for row in cells)
        table.add_column(column, justify="right" if numeric else "left", overflow="fold")
    for row in cells:
        table.add_row(*row)
    if answers().is_terminal:
        answers().print(table, markup=False)
    else:
        Console(width=10_000, highlight=False, emoji=False).print(table, markup=False)


def number(value: float, digits: int = 6) -> str:
    """Write `value` with `digits` significant digits, or a dash if `value` is not finite."""
    return f"{value:.{digits}g}" if math.isfinite(value) else "—"


def two_digits(value: float) -> str:
    """Write a number with two significant digits. A large number is written without an exponent."""
    return f"{float(f'{value:.2g}'):,.15g}" if abs(value) >= 1 else number(value, 2)


def duration(seconds: float | None) -> str:
    """Write a duration in a readable form: "0.8 s", "42 s", "3 min 5 s", "2 h 10 min"."""
    if seconds is None or not math.isfinite(seconds):
        return "unknown"
    if seconds < 10:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    minutes, rest = divmod(whole, 60)
    if minutes < 60:
        return f"{minutes} min {rest} s"
    return f"{minutes // 60} h {minutes % 60} min"


@contextmanager
def working(what: str | Callable[[], str]) -> Iterator[None]:
    """Show an activity and its duration on standard error, if the activity takes more than two seconds.

    `what` describes the activity, as a text or as a function that is called repeatedly.
    """
    done = threading.Event()
    started = time.monotonic()

    def words() -> str:
        return what if isinstance(what, str) else what()

    def show() -> None:
        if done.wait(2.0):
            return
        if notes().is_terminal:
            from rich.text import Text

            with notes().status("") as status:
                while not done.wait(0.5):
                    status.update(Text(f"{words()} … {duration(time.monotonic() - started)}"))
        else:
            note(f"{words()} …")
            while not done.wait(10.0):
                note(f"{words()} … {duration(time.monotonic() - started)}")

    thread = threading.Thread(target=show, daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def make_parent(path: Path) -> Path:
    """Create the parent folder of `path`, and return `path`."""
    path.parent.mkdir(parents=True, exist_ok=True)
    return path


def _is_number(text: str) -> bool:
    try:
        float(text.removesuffix(" %"))
    except ValueError:
        return text == "—"
    return True
