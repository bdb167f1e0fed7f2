"""JSON has no NaN and no infinity, and UTF-8 has no half characters."""

import json
from math import inf, nan

import numpy as np
import pytest

from damperlab.service.documents import AT_ONCE, Document, plain


def test_what_is_not_finite_becomes_null_at_any_depth() -> None:
    value = {"a": [1.0, nan, (inf, -inf)], "b": np.array([[1.5, nan], [inf, 2.0]]), "c": np.float64(nan)}
    expected = {"a": [1.0, None, [None, None]], "b": [[1.5, None], [None, 2.0]], "c": None}
    assert plain(value) == expected
    assert json.loads(Document(value).body) == expected


def test_numbers_come_back_bit_for_bit() -> None:
    values = np.random.default_rng(1).standard_normal(1000) * 10.0 ** np.arange(-500, 500).clip(-300, 300)
    assert json.loads(Document(values).body) == values.tolist()
    assert json.loads(Document(np.array([1, -1], np.int8)).body) == [1, -1]


def test_half_a_character_does_not_break_an_answer() -> None:
    assert json.loads(Document({"found": "\ud800 und ζ"}).body) == {"found": "\ud800 und ζ"}


@pytest.mark.parametrize(
    "shape", [(3 * AT_ONCE + 1,), (AT_ONCE + 7, 3), (2, AT_ONCE + 1), (40, 0), (30, 30, 30), ()]
)
def test_what_is_written_in_pieces_is_what_is_written_in_one_go(shape: tuple[int, ...]) -> None:
    values = np.random.default_rng(2).standard_normal(shape)
    values[values > 2] = nan
    listed = np.where(np.isnan(values), None, values.astype(object)).tolist()
    document = {
        "values": values,
        "odd": {"names": ["ζ", "\ud800"] * AT_ONCE, "none": [], "rows": [{"a": 1}] * AT_ONCE},
    }
    expected = {**document, "values": listed}
    text = json.dumps(expected, ensure_ascii=False, separators=(",", ":"))
    assert Document(document).body == text.encode("utf-8", "backslashreplace")
