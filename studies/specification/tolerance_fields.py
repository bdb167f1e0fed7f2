"""Read tolerances from a document."""

import math
from collections.abc import Mapping

from damperlab.studies.faults import describe
from damperlab.studies.quantity import OF_CAVITY, Quantity
from damperlab.studies.specification.damper import NAME_OF, DamperFields
from damperlab.studies.specification.measure import ROUNDING
from damperlab.studies.specification.specification import (
    CHOSEN,
    OF_DAMPER,
    OF_STRUCTURE,
    RATIO_OF,
    Choice,
    Structure,
    Tolerance,
)
from damperlab.studies.spelling import unit_of
from damperlab.studies.variables import MADE_BY

SHARE = Quantity("share", "share of the value", 0.0, 0.5, "write 10% for a tenth, or a number in the unit")
ANYTHING = Quantity("size", "tolerance", 0.0, 1e12, "write 10% for a tenth, or a number in the unit")
MOST = 7
"""Largest number of tolerances, which is the number of factors in the two-level design for builds."""
BESIDE_LARGEST = ("friction_force_n", "restitution")
"""Quantities whose tolerances are always compared with the largest allowed value, because the quantities may be 0."""


class ToleranceFields(DamperFields):
    """Reads tolerances."""

    def _tolerance_values(self) -> dict[str, Tolerance]:
        """Return the tolerances by key, one for each quantity. `_tolerances` compares them with other fields."""
        ratios = [ratio for ratio in RATIO_OF.values() if ratio not in CHOSEN]
        known = (*OF_DAMPER, *ratios, *OF_STRUCTURE)
        raw = self._mapping("tolerances", known, self.document.get("tolerances", {})) or {}
        found: dict[str, Tolerance] = {}
        seen: set[str] = set()
        for key in raw:
            if key not in known:
                continue
            field, name = f"tolerances.{key}", NAME_OF.get(key, key)
            if name in seen:
                told = f"{{field}} gives the tolerance of {name} a second time."
                self._fault(field, describe(raw[key]), "each tolerance once", "keep one of the two", told)
                continue
            tolerance = self._tolerance(field, raw[key])
            if tolerance is not None:
                found[key] = tolerance
                seen.add(name)
        return found

    def _tolerances(
        self, choices: dict[str, Choice], amplitude_m: float | None, structure: Structure | None
    ) -> dict[str, Tolerance]:
        """Read tolerances and compare each tolerance with the values of the quantity.

        Parameters
        ----------
        choices : dict of Choice
            The allowed values, as given.
        amplitude_m : float or None
            The largest base amplitude. If None, the amplitude is unknown, and ratios cannot be converted.
        structure : Structure or None
            The structure; None if it could not be read.
        """
        found: dict[str, Tolerance] = {}
        for key, tolerance in self._tolerance_values().items():
            name, field = NAME_OF.get(key, key), f"tolerances.{key}"
            if key in MADE_BY.values():
                of_cavity = self._of_cavity(field, key, tolerance, choices)
                found |= {key: of_cavity} if of_cavity else {}
                continue
            if key in OF_STRUCTURE:
                of_structure = structure and self._of_structure(field, key, tolerance, structure)
                found |= {name: of_structure} if of_structure else {}
                continue
            scale = 1.0
            if key != name and not tolerance.relative:
                if structure is None or amplitude_m is None:
                    continue
                scale = structure.reference(unit_of(name), amplitude_m)
            if name in choices:
                self._check_size(field, name, tolerance, choices[name], scale)
            found[name] = Tolerance(tolerance.size * scale, tolerance.relative)
        found = {name: each for name, each in found.items() if each.size > 0}
        if len(found) > MOST:
            told = f"{{field}} has {len(found)} entries; at most {MOST} can be computed together."
            self._fault(
                "tolerances", f"{len(found)}", f"at most {MOST}", "leave out the least important ones", told
            )
        return found

    def _of_cavity(
        self, field: str, key: str, tolerance: Tolerance, choices: Mapping[str, Choice]
    ) -> Tolerance | None:
        """Check the tolerance of a quantity of the cavity against the largest value of this quantity.

        Return None if the quantity is not given, or if the tolerance is 0 or too large.
        """
        about = next(each for each in OF_CAVITY if each.name == key)
        if not (key in self.document or self._has("choose", key)):
            told = f"{{field}} is a tolerance of `{key}`, which is not given."
            found = describe(self.document["tolerances"][key])
            self._fault(field, found, f"a tolerance of a given `{key}`", f"add `{key}`", told)
            return None
        largest = choices[key].stop
        at_bound = largest in (0.0, about.highest)  # the part of the tolerance beyond a bound is cut off
        most = about.highest if at_bound else min(largest, about.highest - largest)
        size = tolerance.of(largest)
        if size > most * (1.0 + ROUNDING):
            told = (
                f"With {{field}} = {size:g}, `{key}` = {largest:g} would leave the range from 0 to "
                f"{about.highest:g}."
            )
            self._fault(field, f"{size:g}", f"at most {most:g}", "check its unit", told)
            return None
        return tolerance if size else None

    def _of_structure(
        self, field: str, key: str, tolerance: Tolerance, structure: Structure
    ) -> Tolerance | None:
        """Return a tolerance of the structure as a relative tolerance, or None if it is invalid or ineffective."""
        value = float(getattr(structure, key))
        if tolerance.relative or not tolerance.size:
            return tolerance if value else None  # a relative tolerance of a value of 0 has no effect
        if not value:
            told = f"{{field}} = {tolerance.size:g} is a tolerance of a {key} of 0, but {key} cannot be negative."
            advice = f"give the middle of the possible range as `{key}`, or leave the tolerance out: 0 is the worst case"
            self._fault(field, f"{tolerance.size:g}", f"a {key} above 0", advice, told)
            return None
        if tolerance.size > SHARE.highest * value * (1.0 + ROUNDING):
            found = f"{100 * tolerance.size / value:.4g} %"
            self._fault(field, found, "at most 50 %", "check its unit")
            return None
        return Tolerance(tolerance.size / value, True)

    def _check_size(self, field: str, name: str, tolerance: Tolerance, choice: Choice, scale: float) -> None:
        """Refuse a tolerance above half of the value. Relative tolerances were checked when they were read."""
        largest = name in BESIDE_LARGEST or not choice.start
        most = SHARE.highest * (choice.stop if largest else choice.start) / scale
        if tolerance.relative or tolerance.size <= most * (1.0 + ROUNDING):
            return
        which = "" if not choice.free else "largest " if largest else "smallest "
        told = (
            f"{{field}} = {tolerance.size:g} is more than half of the {which}specified value, {2 * most:g}."
        )
        advice = "check its unit, choose a closer tolerance, or write a share such as 10%"
        self._fault(field, f"{tolerance.size:g}", f"at most {most:g}", advice, told)

    def _tolerance(self, field: str, raw: object) -> Tolerance | None:
        if isinstance(raw, str) and raw.strip().endswith("%"):
            try:
                share = float(raw.strip()[:-1]) / 100.0
            except ValueError:
                share = math.nan
            if 0.0 <= share <= SHARE.highest:
                return Tolerance(share, True)
            self._fault(
                field, describe(raw), f"a share from 0% to {SHARE.highest:.0%}", "write 10% for a tenth"
            )
            return None
        size = self._read(field, raw, ANYTHING)
        return None if size is None else Tolerance(size, False)
