"""Conditions that select the studies of a list."""

import json
import math
from dataclasses import dataclass
from typing import Any

from sqlalchemy import ColumnElement, Row, not_

from damperlab.studies.faults import Fault, describe, listing, write_nearest
from damperlab.studies.kinds import EVERY_DIMENSION, dimensions_of_definition
from damperlab.studies.remarks import faults_of_tag
from damperlab.studies.store.catalogue.rows import ALIVE, asked_for, in_trash
from damperlab.studies.store.catalogue.tables import studies
from damperlab.studies.store.faults import StoreFault
from damperlab.studies.store.provenance import DESIGNS, REFINES
from damperlab.studies.unit_names import ALIASES, COORDINATE_NAMES
from damperlab.studies.vocabulary import STATES

_OF_TEXTS = ("record",)  # dimensions whose values are texts, which have no range


@dataclass(frozen=True, kw_only=True)
class Wanted:
    """Conditions that a listed study must satisfy. None stands for no condition.

    Parameters
    ----------
    state : str, optional
        State of the study.
    name : str, optional
        Text that the name of the study contains; the case of ASCII letters is ignored.
    tag : str, optional
        Tag that the study has.
    axis : str, optional
        Dimension of the study, or quantity in the study's physical block that corresponds to a dimension.
    low, high : float, optional
        Least and greatest value along `axis`. The values of the study along this axis must overlap this range.
    designs : bool
        Whether to list every study of a design or a refinement. If false, a study of a design or a refinement is listed
        only for a given tag, a given name, or a given state other than `done`.
    trash : bool
        Whether to list deleted studies that can be restored, instead of the existing studies.

    Raises
    ------
    StoreFault
        If a condition is invalid.
    """

    state: str | None = None
    name: str | None = None
    tag: str | None = None
    axis: str | None = None
    low: float | None = None
    high: float | None = None
    designs: bool = True
    trash: bool = False

    def __post_init__(self) -> None:
        """Refuse invalid conditions."""
        for fault in self._faults():
            raise StoreFault(fault)

    def _faults(self) -> list[Fault]:
        names = dict.fromkeys((*EVERY_DIMENSION, *COORDINATE_NAMES, *ALIASES))
        axes = [name for name in names if name not in _OF_TEXTS]
        faults = [] if self.tag is None else faults_of_tag("tag", self.tag)
        if self.state is not None and self.state not in STATES:
            advice = write_nearest(self.state, STATES, "leave it out for every state")
            faults.append(Fault("state", describe(self.state), f"one of {listing(STATES)}", advice))
        if self.axis is not None and self.axis not in axes:
            advice = write_nearest(self.axis, axes, "leave it out for every study")
            faults.append(Fault("axis", describe(self.axis), f"one of {listing(axes)}", advice))
        ends = {"from": self.low, "to": self.high}
        for name, end in ends.items():
            if end is not None and (self.axis is None or math.isnan(end)):
                allowed = "a number" if self.axis else "no value without an axis"
                faults.append(Fault(name, describe(end), allowed, "name the `axis` as well, or leave it out"))
        if None not in ends.values() and self.low > self.high:  # type: ignore[operator]
            faults.append(
                Fault(
                    "to", describe(self.high), f"at least {self.low:g}, the value of `from`", "exchange them"
                )
            )
        return faults

    def clauses(self) -> list[ColumnElement[bool]]:
        """Return the SQL clauses of the conditions that the database can check."""
        found: list[ColumnElement[bool]] = [in_trash() if self.trash else ALIVE]
        if self.state is not None:
            found.append(studies.c.state == self.state)
        if self.name:
            text = self.name.encode(errors="replace").decode().replace("\0", "?")
            found.append(studies.c.name.icontains(text, autoescape=True))
        if self.tag is not None:
            found.append(studies.c.tags.contains(json.dumps(self.tag), autoescape=True))
        if not self.designs and self.tag is None and not self.name and self.state in (None, "done"):
            found += [not_(asked_for(purpose)) for purpose in (DESIGNS, REFINES)]
        return found

    @property
    def looks_inside(self) -> bool:
        """Whether there is a condition on an axis, which the database cannot check."""
        return self.axis is not None

    def fits(self, row: Row[Any]) -> bool:
        """Whether the study's values along the axis overlap the range from `low` to `high`."""
        definition = json.loads(row.definition)
        names = [name for name in dimensions_of_definition(definition) if name not in _OF_TEXTS]
        box = dict(zip(names, json.loads(row.box), strict=True))
        ends = box.get(str(self.axis)) or self._ends_in_units(definition)
        if ends is None:
            return False
        first, last = ends
        reaches = self.low is None or last >= self.low
        return bool(reaches and (self.high is None or first <= self.high))

    def _ends_in_units(self, definition: dict[str, Any]) -> list[float] | None:
        """Return the least and the greatest value of the axis in a physical block; None if the block lacks the axis."""
        physical = definition.get("physical") or {}
        # the excitation frequency has different names in the physical block and as a coordinate
        own = {coordinate: name for name, coordinate in ALIASES.items()}
        given = physical.get(own.get(str(self.axis), self.axis))
        if given is None:
            return None
        values = [given["start"], given["stop"]] if isinstance(given, dict) else given
        values = values if isinstance(values, list) else [values]
        return [float(min(values)), float(max(values))]


ALL = Wanted()
"""Conditions that every existing study satisfies."""
