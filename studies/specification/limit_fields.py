"""Read limits on results and on the damper itself from a document."""

from collections.abc import Mapping
from dataclasses import replace

from damperlab.studies.faults import describe, listing
from damperlab.studies.physical import FRICTION_FORCE, PARTICLE_MASS
from damperlab.studies.quantity import FRICTION_RATIO, MASS_RATIO, Quantity
from damperlab.studies.specification.measure import DAMPER_LIMITS, EVERY_LIMIT, LIMITS, ROUNDING
from damperlab.studies.specification.specification import (
    RATIO_OF,
    Choice,
    Structure,
    Tolerance,
)
from damperlab.studies.specification.tolerance_fields import ToleranceFields

LENGTH = Quantity("length", "length [m]", 1e-12, 1e12, "give it in m")
SPEED = Quantity("speed", "speed [m/s]", 1e-12, 1e12, "give it in m/s")
ACCELERATION = Quantity("acceleration", "acceleration [m/s²]", 1e-12, 1e12, "give it in m/s²")
STICK = Quantity(
    "stick_fraction", "share of time", 1e-3, 1.0, "give a share, such as 0.5 for half of the time"
)
OVER_AMPLITUDE = Quantity("ratio", "ratio [1]", 1e-12, 1e12, "give it over the base amplitude")

QUANTITY_IN = {"m": LENGTH, "m/s": SPEED, "m/s²": ACCELERATION, "1": STICK}
IN_RATIOS = {each.ratio: each.name for each in EVERY_LIMIT.values() if each.ratio and each.ratio != each.name}
"""Name of a limit in SI units, by the name of the limit in ratios, if the two names differ."""
LIMIT_QUANTITIES = {
    **{each.name: QUANTITY_IN[each.unit] for each in LIMITS.values()},
    "cavity_length_m": LENGTH,
    "friction_force_n": FRICTION_FORCE,
    "particle_mass_kg": PARTICLE_MASS,
}
"""Allowed values of each limit in SI units, by the name of the limit."""
RATIO_QUANTITIES = dict.fromkeys(IN_RATIOS, OVER_AMPLITUDE) | {
    "friction_ratio": FRICTION_RATIO,
    "mass_ratio": MASS_RATIO,
}
"""Allowed values of each limit in ratios, by the name of the limit."""
LIMIT_KEYS = tuple(LIMIT_QUANTITIES)


class LimitFields(ToleranceFields):
    """Reads limits."""

    def _limit_values(self) -> dict[str, float]:
        """Return the numbers in `limits` by key. `_limits` compares the numbers with other fields."""
        known = LIMIT_QUANTITIES | RATIO_QUANTITIES
        raw = self._mapping("limits", tuple(known), self.document.get("limits", {})) or {}
        found: dict[str, float] = {}
        for key in known:
            if key in raw:
                limit = self._read(f"limits.{key}", raw[key], known[key])
                if limit is not None:
                    found[key] = limit
                if key in LIMITS and not LIMITS[key].under_record and not self._shaken_over_bands:
                    self._without_period(key)
        return found

    def _without_period(self, key: str) -> None:
        """Refuse a limit on a result that is not defined for the response to a record."""
        told = (
            "{field} applies only to bands of frequencies: it is a mean over the cycles of a steady "
            "response, and a response to a ground-motion record has no steady cycles."
        )
        advice = "limit `impact_speed_m_per_s`, or add a band of frequencies to the excitations"
        self._fault(
            f"limits.{key}", "records alone", "a band of frequencies among the excitations", advice, told
        )

    def _limits(self, amplitude_m: float, structure: Structure) -> dict[str, float]:
        """Return the limits in SI units. Limits given as ratios are converted."""
        values = self._limit_values()
        if self._in_units:
            for key in (each for each in values if each in IN_RATIOS):
                told = "{field} is a ratio, but the specification is in units."
                name = IN_RATIOS[key]
                self._fault(f"limits.{key}", f"{values[key]:g}", f"`{name}`", f"give `{name}`", told)
            return {key: limit for key, limit in values.items() if key not in IN_RATIOS}
        in_units = [key for key in values if key not in IN_RATIOS and key != STICK.name]
        if in_units:
            told = "{field} are in units, but the specification is in ratios."
            ratios = [each.ratio for each in EVERY_LIMIT.values() if each.name in in_units and each.ratio]
            give = f"give {listing(ratios)}, or add" if ratios else "add"
            self._fault(
                "limits",
                describe(self.document["limits"]),
                "limits with a structure and a base motion in units",
                f"{give} mass_kg, natural_frequency_hz and base_amplitude_m",
                told,
            )
        ratios_of = {IN_RATIOS.get(key, key): limit for key, limit in values.items() if key not in in_units}
        return {
            each.name: ratios_of[each.name] * structure.reference(each.unit, amplitude_m)
            for each in EVERY_LIMIT.values()
            if each.name in ratios_of
        }

    def _within_limits(
        self,
        choices: dict[str, Choice],
        limits: dict[str, float],
        tolerances: dict[str, Tolerance],
        units: Mapping[str, float],
    ) -> dict[str, str]:
        """Restrict the damper to values that, including their tolerances, stay within the limits on the damper.

        Parameters
        ----------
        choices : dict of Choice
            The allowed values of each quantity, which are changed in place.
        limits : dict of float
            Limits by name, in units.
        tolerances : dict of Tolerance
            Tolerances by quantity.
        units : mapping of float
            Reference quantity of each limit given as a ratio, by name; empty if the document is in units.

        Returns
        -------
        dict of str
            For each quantity whose range was shortened, the limit that shortened the range.
        """
        bounds: dict[str, str] = {}
        exact = Tolerance(0.0, True)
        for name, limit in limits.items():
            quantity = DAMPER_LIMITS[name].quantity if name in DAMPER_LIMITS else ""
            if quantity not in choices:
                continue
            unit = units.get(name, 1.0)
            if self._cut(choices, name, limit, tolerances.get(quantity, exact), unit):
                bounds[quantity] = f"limits.{self._limit_key(name)}"
        return bounds

    def _limit_key(self, name: str) -> str:
        return name if self._in_units else DAMPER_LIMITS[name].ratio

    def _cut(
        self,
        choices: dict[str, Choice],
        limit_name: str,
        limit: float,
        tolerance: Tolerance,
        unit: float,
    ) -> bool:
        """Shorten a range at a limit, and return whether the range changed. Record a fault if no value remains."""
        about = DAMPER_LIMITS[limit_name]
        choice = choices[about.quantity]
        most = tolerance.most(limit / about.factor) * (1.0 + ROUNDING)
        if choice.stop <= most:
            return False
        if choice.start > most:
            self._excludes(choice, limit_name, limit, tolerance, unit)
            return False
        values = tuple(value for value in choice.values if value <= most)
        stop = values[-1] if values else max(tolerance.most(limit / about.factor), choice.start)
        choices[about.quantity] = replace(choice, stop=stop, values=values, names=choice.names[: len(values)])
        return True

    def _excludes(
        self, choice: Choice, limit_name: str, limit: float, tolerance: Tolerance, unit: float
    ) -> None:
        about, key = DAMPER_LIMITS[limit_name], self._limit_key(limit_name)
        quantity = about.quantity if self._in_units else RATIO_OF[about.quantity]
        least = choice.start / unit
        needed = about.factor * (choice.start + tolerance.of(choice.start)) / unit
        why = ["the cavity is twice as long"] if about.factor == 2.0 else []
        why += (
            [f"with its tolerance, {quantity} reaches {(choice.start + tolerance.of(choice.start)) / unit:g}"]
            if tolerance.size
            else []
        )
        told = (
            f"{{field}} = {limit / unit:g} excludes every allowed {quantity}; the smallest is {least:g}"
            f"{' (' + '; '.join(why) + ')' if why else ''}."
        )
        advice = f"relax it to at least {needed:g}, or allow a smaller `{quantity}`"
        self._fault(f"limits.{key}", f"{limit / unit:g}", f"at least {needed:g}", advice, told)
