"""Sources as far as they compute: prose does not count, everything else does."""

import ast
import io
import tokenize
from pathlib import Path

import pytest
from tests.worker.forms import night

from damperlab.studies.store.solver import computing_lines, hash_of

ROOT = Path(__file__).parents[3]


def without_prose(text: str) -> list[str]:
    """The lines that Python's own parser finds to hold more than a docstring or a comment, without their comments."""
    lines = text.splitlines()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            row, column = token.start
            lines[row - 1] = lines[row - 1][:column]
    held = {
        row
        for statement in ast.walk(ast.parse(text))
        if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)
        for row in range(statement.lineno, (statement.end_lineno or 0) + 1)
    }
    return [line.rstrip() for row, line in enumerate(lines, 1) if line.strip() and row not in held]


@pytest.mark.parametrize(
    "rooms", [["worker/physics", "worker/steady", "studies/store"], night(["worker", "studies"])], ids=str
)
def test_prose_alone_is_left_out_of_every_source(rooms: list[str]) -> None:
    for source in (each for room in rooms for each in (ROOT / room).rglob("*.py")):
        text = source.read_text()
        found, expected = list(computing_lines(text)), without_prose(text)
        # inside a text of several lines blank ones count, and a comment may stay behind a line that holds a quote
        found = [line for line in found if line.strip()]
        assert len(found) == len(expected), source
        for line, bare in zip(found, expected, strict=True):
            assert line.startswith(bare), (source, line)
            assert not line[len(bare) :].strip() or line[len(bare) :].lstrip().startswith("#"), (source, line)


SOURCE = '''"""What it is."""

SCALE = 2.0  # why
"""What that is,
in two lines."""


def scaled(x):
    """Scale."""
    return SCALE * x
'''


@pytest.mark.parametrize(
    ("old", "new", "alike"),
    [
        ("What it is", "It", True),
        ("# why", "# because", True),
        ("in two lines", "in\nthree", True),
        ("\n\n\n", "\n", True),
        ("\n", "\r\n", True),
        ("2.0", "3.0", False),
        ("    return", "  return", False),
        ("scaled", "other", False),
    ],
)
def test_a_source_is_hashed_by_what_it_computes(tmp_path: Path, old: str, new: str, alike: bool) -> None:
    source = tmp_path / "law.py"
    source.write_text(SOURCE)
    before = hash_of(tmp_path, ["law.py"])
    source.write_bytes(SOURCE.replace(old, new).encode())
    assert (hash_of(tmp_path, ["law.py"]) == before) is alike
    assert hash_of(tmp_path, ["law.py", "."]) != before
