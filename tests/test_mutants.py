"""The list of `make mutants`: each mistake can still be made."""

import pytest
from tests.mutants import MUTANTS, ROOT, Mutant


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda each: each.test.rpartition("/")[2])
def test_the_text_that_a_mistake_changes_stands_once_in_its_file(mutant: Mutant) -> None:
    assert (ROOT / mutant.file).read_text().count(mutant.text) == 1
    assert (ROOT / mutant.test.partition("::")[0]).is_file()
