"""A ground-motion suite: a study over records, scale factors and design parameters, all in physical units."""

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.axes import AxisSpec, Coordinates, Range, axis_count, axis_values
from damperlab.studies.cavity import Cavity, cavity_of
from damperlab.studies.choices import Contact
from damperlab.studies.digest import feed
from damperlab.studies.faults import Fault, StudyFaults
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.source import RecordSource
from damperlab.studies.ground.variables import DIMENSIONS, RECORD, VARIABLES
from damperlab.studies.variables import MADE_BY, Variable

AXES: tuple[str, ...] = tuple(name for name in DIMENSIONS if name != RECORD)
"""Axes of a suite, apart from the records."""

NUMBERS = ("mass_kg", "tail_s", "perturbation_m", *MADE_BY.values())

_SCHEME = b"damperlab survey 1"
"""First part of the hashed content. Keep this value unless the computation or storage of suites changes."""


@dataclass(frozen=True)
class Suite:
    """A ground-motion suite: a grid of responses to records. `read_suite` returns only valid suites.

    Parameters
    ----------
    name : str
        Free text.
    records : tuple of RecordSource
        Records, sorted by id, because the order has no meaning. The values of every axis are sorted too.
    axes : dict of AxisSpec
        Values of each of `AXES`.
    numbers : dict of float
        Values of `NUMBERS`. Zero friction and zero tilt of the cavity are left out.
    starts, seed : int
        Number of perturbed starts of each point in addition to the start at rest, and the seed for drawing the starts.
    contact : Contact
        Contact model for impacts.
    metrics : tuple of str
        Names of the stored variables.
    motions : mapping of GroundMotion
        Samples of each record, by its id; empty if the suite is read from a store.
    """

    name: str
    records: tuple[RecordSource, ...]
    axes: dict[str, AxisSpec]
    numbers: dict[str, float]
    starts: int
    seed: int
    contact: Contact
    metrics: tuple[str, ...]
    motions: Mapping[str, GroundMotion] = field(default_factory=dict, compare=False, repr=False)

    @cached_property
    def coordinates(self) -> Coordinates:
        """Read-only coordinates of the cube: record ids as text, and the values of each of `AXES` as float64."""
        axes = {name: axis_values(self.axes[name]) for name in AXES}
        return Coordinates({RECORD: np.array([record.id for record in self.records]), **axes})

    @property
    def identities(self) -> dict[str, NDArray[Any]]:
        """The coordinates. Each record id is followed by the hash of the record's samples."""
        told = np.array([f"{record.id} {record.sha256}" for record in self.records])
        return self.coordinates | {RECORD: told}

    @property
    def cavity(self) -> Cavity:
        """Tilt of the cavity, and friction of the particle in it."""
        return cavity_of(self.numbers)

    @property
    def labels(self) -> dict[str, dict[str, str]]:
        """``units`` and ``long_name`` of the dimensions."""
        return {name: {"units": unit, "long_name": words} for name, (unit, words) in DIMENSIONS.items()}

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of records, followed by the number of values along each of `AXES`."""
        return (len(self.records), *(axis_count(self.axes[name]) for name in AXES))

    @property
    def points(self) -> int:
        """Number of points: one for every combination of a record and values along `AXES`."""
        return math.prod(self.shape)

    @property
    def variables(self) -> dict[str, Variable]:
        """Variables of a suite, in the order of the cube."""
        return VARIABLES

    @property
    def whole_rows(self) -> bool:
        """Always false for a suite, because no point starts from the result of another point."""
        return False

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the samples of the records, the values of the axes and the settings, in hexadecimal."""
        content = hashlib.sha256(_SCHEME)
        for name, values in self.identities.items():
            text = values.dtype.kind == "U"
            feed(content, name, "\n".join(values).encode() if text else values.astype("<f8").tobytes())
        settings = self.settings() | {"metrics": self.metrics}
        feed(content, "settings", json.dumps(settings, sort_keys=True).encode())
        return content.hexdigest()

    def settings(self) -> dict[str, Any]:
        """Return the settings that, together with the coordinates, determine the results at a point."""
        settings = {"contact": self.contact.model_dump(mode="json"), "starts": self.starts, **self.numbers}
        if self.starts:
            return settings | {"seed": self.seed}
        del settings["perturbation_m"]
        return settings

    @property
    def attached(self) -> dict[str, str]:
        """SHA-256 of each record, by the name of the file that holds the record in the cube."""
        return {record.key: record.sha256 for record in self.records}

    def attachments(self) -> dict[str, bytes]:
        """Return the samples of the records by file name, to be stored with the definition for the workers.

        Raises
        ------
        StudyFaults
            If the samples of a record are not available.
        """
        lost = [record.id for record in self.records if record.id not in self.motions]
        if lost:
            advice = "upload the record again"
            raise StudyFaults(
                Fault(
                    "records",
                    f"{each}, whose samples are gone",
                    "a record whose samples are stored",
                    advice,
                    f"The samples of record {each} are no longer stored.",
                )
                for each in lost
            )
        return {record.key: self.motions[record.id].content for record in self.records}

    def document(self) -> dict[str, Any]:
        """Return the suite as JSON-able data, from which `read_suite` returns an equal suite."""
        axes = {
            name: spec.model_dump() if isinstance(spec, Range) else spec for name, spec in self.axes.items()
        }
        return {
            "name": self.name,
            "records": [record.document() for record in self.records],
            "axes": {name: list(spec) if isinstance(spec, tuple) else spec for name, spec in axes.items()},
            **self.numbers,
            "starts": self.starts,
            "seed": self.seed,
            "contact": self.contact.model_dump(mode="json"),
            "metrics": list(self.metrics),
        }


def windows_of(
    source: RecordSource, natural_frequency_hz: NDArray[np.float64] | float, tail_s: float
) -> NDArray[np.float64]:
    """Estimate the number of time steps of a run.

    At high natural frequencies, a run takes several time steps for each step of the record.
    """
    shortest = np.minimum(source.step_s, 0.4 / (2.0 * math.pi * np.asarray(natural_frequency_hz)))
    return np.asarray((source.duration_s + tail_s) / shortest)
