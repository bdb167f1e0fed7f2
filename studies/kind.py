"""The common interface of all kinds of study, for planning, storage and scheduling."""

from collections.abc import Mapping
from typing import Any, Protocol

from numpy.typing import NDArray

from damperlab.studies.variables import Variable


class AnyStudy(Protocol):
    """A grid of points over named dimensions, and the results stored for each point."""

    @property
    def name(self) -> str:
        """Name of the study, any text."""

    @property
    def coordinates(self) -> Mapping[str, NDArray[Any]]:
        """The values along every dimension, in the order of the cube. Each array is 1-D and increasing."""

    @property
    def labels(self) -> Mapping[str, Mapping[str, str]]:
        """``units`` and ``long_name`` of every dimension."""

    @property
    def identities(self) -> Mapping[str, NDArray[Any]]:
        """Coordinates for comparing the points of different studies, in the order of `coordinates`."""

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
        """Whether blocks must contain the complete last dimension, because each point starts from the previous one."""

    @property
    def digest(self) -> str:
        """SHA-256 hash of the content of the study, 64 hexadecimal digits."""

    def settings(self) -> dict[str, Any] | None:
        """Return all settings that determine the results at given coordinates; None if results cannot be shared."""

    @property
    def attached(self) -> Mapping[str, str]:
        """SHA-256 hash of each file that workers need in addition to the definition, by the file's key in the cube."""

    def attachments(self) -> dict[str, bytes]:
        """Return the attached files by their keys in the cube.

        Raises
        ------
        StudyFaults
            If the sources of the files are not available.
        """

    def document(self) -> dict[str, Any]:
        """Return the study as JSON-able data. Parsing the data gives an equal study."""
