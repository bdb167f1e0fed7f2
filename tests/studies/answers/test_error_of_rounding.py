"""An error that is rounding is no error that somebody reads: it is left out of sentences, and a word in tables."""

import numpy as np
import pytest
import xarray as xr

from damperlab.service.cli.words import rows_table
from damperlab.studies.answers.phrases import RATIOS
from damperlab.studies.rounding import is_rounding


@pytest.mark.parametrize(
    ("value", "error", "words"),
    [
        (2.78743, 6.8e-15, "2.78743"),
        (2.78743, 0.0, "2.78743"),
        (0.0, 0.0, "0"),
        (-2.0, 1e-12, "-2"),
        (2.0, 1e-6, "2 ± 1e-06"),
        (1.84424, 0.033, "1.84424 ± 0.033"),
        (2.0, float("nan"), "2 (error not known)"),
    ],
)
def test_a_value_known_to_rounding_has_no_error_beside_it(value: float, error: float, words: str) -> None:
    assert RATIOS.measured(value, error) == words
    # an error of nothing is not rounding
    assert not is_rounding(0.0 * value, 1e-20)


@pytest.mark.parametrize(
    ("value", "error"),
    [("value", "error"), ("amplitude_ratio", "amplitude_error"), ("hybrid", "amplitude_error")],
)
def test_a_table_says_rounding_and_keeps_the_other_errors(value: str, error: str) -> None:
    answer = xr.Dataset(
        {value: ("rank", [1.5, 1.6, np.nan]), error: ("rank", [2e-16, 0.03, np.nan])}, {"rank": [1, 2, 3]}
    )
    head, rows = rows_table(answer, RATIOS)
    place = [column.split()[0] for column in head].index(error)
    assert [row[place] for row in rows] == ["rounding", "0.03", "—"]
