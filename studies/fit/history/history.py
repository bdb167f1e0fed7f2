"""A measured time history: the displacement of the structure at equal time steps, and the acceleration of the base."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Column = NDArray[np.float64]


@dataclass(frozen=True)
class History:
    """A displacement over time, from the beginning of the motion.

    Parameters
    ----------
    name : str
        Name of the measurement.
    step_s : float
        Time between samples [s].
    displacement_m : ndarray, shape (rows,)
        Displacement of the structure [m]. If the base rests, the displacement is measured from the structure's rest
        position without friction.
    relative : bool
        Whether the displacement is relative to the base. Without base motion, relative and absolute displacement agree.
    base_m_s2 : ndarray, shape (rows,), optional
        Acceleration of the base [m/s²], linear between samples; None if the base rests and the structure is
        released.
    deviation_m : ndarray, shape (rows,), optional
        Standard deviation of each displacement [m]; None if it is estimated from the scatter.
    before_release : int
        Number of rows before the release, which are left out of the columns.
    """

    name: str
    step_s: float
    displacement_m: Column = field(repr=False)
    relative: bool = True
    base_m_s2: Column | None = field(default=None, repr=False)
    deviation_m: Column | None = field(default=None, repr=False)
    before_release: int = 0

    @property
    def rows(self) -> int:
        """Number of samples."""
        return self.displacement_m.size

    @property
    def time_s(self) -> Column:
        """Times of the samples, from 0 [s]."""
        return np.asarray(np.arange(self.rows) * self.step_s, np.float64)

    @property
    def duration_s(self) -> float:
        """Time from the first sample to the last [s]."""
        return (self.rows - 1) * self.step_s

    @property
    def released(self) -> bool:
        """Whether the structure is released and the base rests."""
        return self.base_m_s2 is None

    @property
    def largest_m(self) -> float:
        """Largest |displacement| [m]."""
        return float(np.abs(self.displacement_m).max())
