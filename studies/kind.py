"""The interface of every kind of study, on which planning, storing and scheduling rely."""

from collections.abc import Mapping
from typing import Any, Protocol

from numpy.typing import NDArray

from damperlab.studies.variables import Variable


class AnyStudy(Protocol):
    """A grid of points over named dimensions, and the results stored for each point."""

    @property
    def name(self) -> str:
        """Free text."""

    @property
    def coordinates(self) -> Mapping[str, NDArray[Any]]:
        """The values along every dimension, each 1-D and increasing, in the cube's order."""

    @property
    def labels(self) -> Mapping[str, Mapping[str, str]]:
        """``units`` and ``long_name`` of every dimension."""

    @property
    def identities(self) -> Mapping[str, NDArray[Any]]:
        """The coordinates that distinguish points of different studies, in the same order."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values along each dimension."""

    @property
    def points(self) -> int:
        """Number of points."""

    @property
    def variables(self) -> Mapping[str, Variable]:
        """Every variable of this kind of study, in the cube's order."""

    @property
    def metrics(self) -> tuple[str, ...]:
        """Names of the variables that are stored."""

    @property
    def whole_rows(self) -> bool:
        """Whether a block must contain the complete last dimension, because each point there starts from the previous
        one.
        """

    @property
    def digest(self) -> str:
        """Digest of the study's content, 64 hexadecimal digits."""

    def settings(self) -> dict[str, Any] | None:
        """Give everything that a point's values depend on except its coordinates; None if they depend on its
        neighbours.
        """

    @property
    def attached(self) -> Mapping[str, str]:
        """The files that workers need as well as the definition: their keys in the cube, and the SHA-256 of each."""

    def attachments(self) -> dict[str, bytes]:
        """Give these files by their keys.

        Raises
        ------
        StudyFaults
            If their sources are not available.
        """

    def document(self) -> dict[str, Any]:
        """Give the study as JSON-able data that parses back to an equal study."""
