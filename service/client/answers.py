"""Answers of the service as xarray Datasets, each with a method that draws its figure."""

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
    """The plot accessor of xarray, which draws the complete answer when it is called."""

    def __call__(self, path: str | Path | None = None) -> "Figure":  # type: ignore[override]
        """Draw the answer.

        Parameters
        ----------
        path : path, optional
            File to which the figure is also written; the suffix gives the format: .png, .svg or .pdf.

        Returns
        -------
        Figure
            The figure; a notebook displays it.
        """
        answer = self._ds
        assert isinstance(answer, Answer)
        return finished(answer._draw(), path)


class Answer(xr.Dataset):
    """An answer as a Dataset; ``answer.plot()`` or ``answer.plot("figure.png")`` draws the answer."""

    __slots__ = ()
    _question: ClassVar[Question[Any]]

    @property
    def plot(self) -> _Plot:  # type: ignore[override]
        """Draw the complete answer. Methods of xarray, such as ``plot.scatter``, draw parts of the answer."""
        return _Plot(self)

    def _draw(self) -> "Figure":
        return self._question.draw(self, tuple(self.attrs.get("studies", ())))


class ResonanceMap(Answer):
    """Values of one metric over two dimensions of a study."""

    __slots__ = ()
    _question = RESONANCE_MAP


class FrequencyResponse(Answer):
    """Values of one metric over the frequency ratio."""

    __slots__ = ()
    _question = FREQUENCY_RESPONSE


class Designs(Answer):
    """Designs along ``rank``, the best first."""

    __slots__ = ()
    _question = OPTIMAL_DESIGNS


class TmdComparison(Answer):
    """Responses of a design and of a tuned mass damper over the frequency ratio."""

    __slots__ = ()
    _question = TMD_COMPARISON


class Fragility(Answer):
    """Probability that the response of a damper exceeds a limit; ``scale`` multiplies the ground-motion records."""

    __slots__ = ()
    _question = FRAGILITY


class WorkPrecision(Answer):
    """Number of points of a study in each bin of error and run time."""

    __slots__ = ()
    _question = WORK_PRECISION


class DamperComparison(Answer):
    """Responses of several dampers to one ground motion, along ``case``."""

    __slots__ = ()

    def _draw(self) -> "Figure":
        from damperlab.service.figures.measures import draw_measures

        return draw_measures(self)


def read(question: Question[A], document: Mapping[str, Any]) -> A:
    """Rebuild the answer to a question from the document that the service sends."""
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
"""Meaning and unit of each column of a time history."""


def read_history(columns: Mapping[str, Any]) -> xr.Dataset:
    """Convert the columns of a time history into a Dataset along ``time``. Without columns the Dataset is empty."""
    arrays = {
        name: (
            ("time",),
            array_of(values, "f8"),
            dict(zip(("long_name", "units"), HISTORY.get(name, (name, "1")), strict=True)),
        )
        for name, values in columns.items()
    }
    return xr.Dataset(arrays).set_coords("time") if arrays else xr.Dataset()
