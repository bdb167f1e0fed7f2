"""Filter of the studies in a list."""

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

_OF_TEXTS = ("record",)  # dimensions without a range in a study's box


@dataclass(frozen=True, kw_only=True)
class Wanted:
    """Conditions of a listed study; None for no condition.

    Parameters
    ----------
    state : str, optional
        Its state.
    name : str, optional
        A text contained in its name; the case of ASCII letters is ignored.
    tag : str, optional
        One of its tags.
    axis : str, optional
        One of its dimensions, or a quantity in its physical block that corresponds to a dimension.
    low, high : float, optional
        The least and the greatest value of `axis`. The study's axis, from its first to its last value, must overlap
        this range.
    designs : bool
        Whether to include studies submitted by designs and refinements. Otherwise they appear only if they have the
        requested tag, name, or state other than done.
    trash : bool
        Whether to list deleted studies that can be restored, instead of the existing ones.

    Raises
    ------
    StoreFault
        If one of the conditions is not allowed.
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
        """Refuse conditions that no study can satisfy."""
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
                allowed = "a number" if self.axis else "nothing, unless an axis is named"
                faults.append(Fault(name, describe(end), allowed, "name the `axis` as well, or leave it out"))
        if None not in ends.values() and self.low > self.high:  # type: ignore[operator]
            faults.append(
                Fault(
                    "to", describe(self.high), f"at least {self.low:g}, the value of `from`", "exchange them"
                )
            )
        return faults

    def clauses(self) -> list[ColumnElement[bool]]:
        """Give the conditions that the database can check."""
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
        """Whether rows must be read to check further conditions."""
        return self.axis is not None

    def fits(self, row: Row[Any]) -> bool:
        """Whether the grid of a study overlaps the range."""
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
        """Give the least and the greatest value in units of a study in ratios; None if it has none."""
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
"""Every study."""
