"""Answers as xarray Datasets, with their figures. They are rebuilt from the service's documents and equal those of
`studies.answers`.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, cast

import xarray as xr
from xarray.plot.accessor import DatasetPlotAccessor

from damperlab.service.client.figure import finished
from damperlab.service.questions.forms import array_of
from damperlab.service.questions.fragility import FRAGILITY
from damperlab.service.questions.frequency_response import FREQUENCY_RESPONSE
from damperlab.service.questions.optimal_designs import OPTIMAL_DESIGNS
from damperlab.service.questions.question import A, Question
from damperlab.service.questions.resonance_map import RESONANCE_MAP
from damperlab.service.questions.tmd_comparison import TMD_COMPARISON
from damperlab.service.questions.work_precision import WORK_PRECISION
from damperlab.studies.answers.quantities import with_words

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class _Plot(DatasetPlotAccessor):
    """A call draws the complete answer; `plot.scatter` and the like are xarray's."""

    def __call__(self, path: str | Path | None = None) -> "Figure":  # type: ignore[override]
        """Draw the answer.

        Parameters
        ----------
        path : path, optional
            Also write the figure there; the suffix gives the format: .png, .svg, .pdf.

        Returns
        -------
        Figure
            The figure; a notebook displays it.
        """
        answer = self._ds
        assert isinstance(answer, Answer)
        return finished(answer._draw(), path)


class Answer(xr.Dataset):
    """A Dataset with its own figure: ``answer.plot()`` or ``answer.plot("figure.png")``.

    Each question to a study has its own class, for readers and type checkers.
    """

    __slots__ = ()
    _question: ClassVar[Question[Any]]

    @property
    def plot(self) -> _Plot:  # type: ignore[override]
        """Draw the complete answer, or parts of it with xarray's own ``plot.scatter`` and others."""
        return _Plot(self)

    def _draw(self) -> "Figure":
        return self._question.draw(self, tuple(self.attrs.get("studies", ())))


class ResonanceMap(Answer):
    """One metric over two dimensions."""

    __slots__ = ()
    _question = RESONANCE_MAP


class FrequencyResponse(Answer):
    """One metric over the frequency ratio."""

    __slots__ = ()
    _question = FREQUENCY_RESPONSE


class Designs(Answer):
    """Designs along ``rank``, the best first."""

    __slots__ = ()
    _question = OPTIMAL_DESIGNS


class TmdComparison(Answer):
    """A design compared with a tuned mass damper over the frequency ratio."""

    __slots__ = ()
    _question = TMD_COMPARISON


class Fragility(Answer):
    """Probability that a damper exceeds a limit along ``scale``."""

    __slots__ = ()
    _question = FRAGILITY


class WorkPrecision(Answer):
    """Error against run time over the points of a study."""

    __slots__ = ()
    _question = WORK_PRECISION


class DamperComparison(Answer):
    """Dampers along ``case`` under one ground motion."""

    __slots__ = ()

    def _draw(self) -> "Figure":
        from damperlab.service.figures.measures import draw_measures

        return draw_measures(self)


def read(question: Question[A], document: Mapping[str, Any]) -> A:
    """Rebuild the answer to a question from its document."""
    known = [each for each in Answer.__subclasses__() if getattr(each, "_question", None) is question]
    kind = known[0] if known else type("Answer", (Answer,), {"__slots__": (), "_question": question})
    return cast(A, with_words(kind(*question.form.read(document))))


HISTORY = {
    "time": ("time", "1/ω_n"),
    "u": ("displacement of the mass", "Z"),
    "u_rate": ("velocity of the mass", "Z·ω_n"),
    "v": ("displacement of the mass relative to the base", "Z"),
    "v_rate": ("velocity of the mass relative to the base", "Z·ω_n"),
    "p": ("displacement of the particle", "Z"),
    "p_rate": ("velocity of the particle", "Z·ω_n"),
    "impact": ("1 where an impact ends", "1"),
}
"""Columns of a time history: their meaning and unit."""


def read_history(columns: Mapping[str, Any]) -> xr.Dataset:
    """Convert the columns of a time history into a Dataset over ``time``; empty if there are none."""
    arrays = {
        name: (
            ("time",),
            array_of(values, "f8"),
            dict(zip(("long_name", "units"), HISTORY.get(name, (name, "1")), strict=True)),
        )
        for name, values in columns.items()
    }
    return xr.Dataset(arrays).set_coords("time") if arrays else xr.Dataset()
