"""The short answer of a ranking: the best damper with its value, the next best dampers, and what to compute next."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from damperlab.studies.answers.comparing import CONFIDENCE, chance_of_another, contend
from damperlab.studies.answers.design_question import DesignQuestion
from damperlab.studies.answers.excited import excitation_of, name_of
from damperlab.studies.answers.flatness import LOSS, end_of, flatness, say_beyond
from damperlab.studies.answers.hidden_peak import PEAK_BETWEEN, hidden_of, hidden_peaks
from damperlab.studies.answers.judging import REASONS
from damperlab.studies.answers.largest_acceleration import acceleration_of, acceleration_rows
from damperlab.studies.answers.linear_peaks import LinearPeaks
from damperlab.studies.answers.notes import advised_axis, sentence_of
from damperlab.studies.answers.phrases import AMPLITUDE, FREQUENCY, Phrases, said
from damperlab.studies.brief import (
    DOUBTS,
    EQUAL,
    PLACES,
    Brief,
    Damper,
    Note,
    command,
    damper_of,
    listed,
    notes_document,
)
from damperlab.studies.faults import Fault
from damperlab.studies.variables import ResponseClass, Status, dimensions_of
from damperlab.studies.vocabulary import OF_PARTICLE

if TYPE_CHECKING:
    import xarray as xr

UNRESOLVED = 0.03
"""Relative error above which the value of the best design counts as not resolved."""
CLAMPED = 1.5
"""Largest amplitude ratio of a mass that counts as clamped."""
HELD = 0.1
"""A mass counts as clamped only if friction holds it at this share of the frequencies or more."""
NEXT_BAND = {"start": 0.8, "stop": 1.25, "num": 19}
"""Frequencies to compute next if a study has only one frequency."""
OTHERS = 2
"""Number of further designs that are listed below the best design."""
BUILT = ("mass_ratio", "clearance_ratio", "friction_ratio", "restitution")
"""Parameters that define a damper with a particle, in the order of a sentence."""

Row = Mapping[str, Any]
"""A design: its coordinates, `value`, `error`, and other results."""


def is_clamped(design: Row) -> bool:
    """Whether friction locks the structure of a design to its base."""
    return float(design["impact_share"]) == 0 and _is_held(design)


def _is_held(design: Row) -> bool:
    """Whether friction holds the structure at a share `HELD` of the frequencies, and the value is at most `CLAMPED`."""
    return float(design["locked_share"]) >= HELD and float(design["value"]) <= CLAMPED


def best_with_impacts(found: "xr.Dataset") -> dict[str, Any] | None:
    """Return the best design whose particle strikes at a judged frequency, or None if no such design is known."""
    if found.sizes["rank"] == 0:
        return None
    rank = {
        name: found[name].values.item()
        for name in (*dimensions_of(found.coords), "value", "error", "impact_share", "study")
        if name in found
    }
    kind = ResponseClass(int(found["response_class"].values.item()))
    return {**rank, "response_class": kind.name.lower()}


def verdict(
    cube: "xr.Dataset",
    question: DesignQuestion,
    ranked: "xr.Dataset",
    active: Row | None,
    flat: list[dict[str, Any]],
    homes: "Mapping[str, xr.Dataset] | None" = None,
) -> dict[str, Any]:
    """Describe the result of a ranking, and say how certain it is.

    Parameters
    ----------
    cube, question : Dataset, DesignQuestion
        The study and the question.
    ranked : Dataset
        The designs, the best first, with `lowest` and `highest`, including all designs that may be the best.
    active : mapping or None
        The design from `best_with_impacts`.
    flat : list of dict
        The result of `flatness.flatness` for the best design.
    homes : mapping of Dataset, optional
        The cubes that hold the designs, by the ids in the variable `study` of `ranked`. By default `cube` holds all
        designs.

    Returns
    -------
    dict
        Attributes of the answer. `confidence` is the confidence of `lowest` and of `highest`, and `as_good`
        the number of further designs that may be the best within their errors. `chance_of_another` is the
        probability that a design other than the first is the best; it is left out if errors are unknown.
        `best_with_impacts` is left out if no design with impacts is known. `clamped` is present if friction
        clamps the structure of the best design. `next_frequencies`, the frequencies to compute next, is
        present if only one frequency was judged. `acceleration_g` is the largest acceleration of the
        structure, if it is known.
        `brief` is the short answer, `verdict` holds the sentences of the short answer, and `notes` all remarks as data.
        `doubts` are the notes that cast doubt on the best value, each with its `kind` (`DOUBTS`). `in_units`
        has the same texts in units, and is left out if the study is given in ratios alone.
    """
    if ranked.sizes["rank"] == 0:
        none = none_left(cube, question, ranked.attrs)
        waits = ranked.attrs["incomplete"] == ranked.attrs["designs"]
        following = command("run", name_of(cube)) if waits else f"{none.advice}."
        brief = Brief(None, (none.sentence,), (), following)
        nothing = {"verdict": list(brief.sentences), "brief": brief.document(), "doubts": []}
        return said(cube, lambda _: nothing)
    values, highest = ranked["value"].values, ranked["highest"].values
    errors = np.where(np.isnan(highest), np.nan, ranked["error"].values)
    may_be = contend(ranked["lowest"].values, highest)
    # the first design has the best value, and is therefore at index 0 of `values[may_be]`
    chance = chance_of_another(values[may_be], errors[may_be], 0)
    found: dict[str, Any] = {"confidence": CONFIDENCE, "as_good": int(may_be[1:].sum())}
    if not math.isnan(chance):
        found["chance_of_another"] = chance
    known = _Known(cube, question, ranked, active, flat, homes)
    if active is not None:
        found["best_with_impacts"] = dict(active)
    if known.clamped:
        found["clamped"] = True
    if question.frequencies.size == 1:
        found["next_frequencies"] = dict(NEXT_BAND)
    if math.isfinite(known.acceleration_g):
        found["acceleration_g"] = known.acceleration_g

    def words(phrases: Phrases) -> dict[str, Any]:
        brief = known.brief(phrases)
        return {
            "verdict": list(brief.sentences),
            "brief": brief.document(),
            "doubts": known.doubts(phrases),
        }

    return found | {"notes": notes_document(known.notes)} | said(cube, words)


@dataclass(frozen=True)
class _Known:
    """The data for the sentences of the short answer. The parameters are those of `verdict`."""

    cube: "xr.Dataset"
    question: DesignQuestion
    ranked: "xr.Dataset"
    active: Row | None
    flat: list[dict[str, Any]]
    homes: "Mapping[str, xr.Dataset] | None"

    @cached_property
    def rows(self) -> list[Row]:
        """The first designs of the ranking."""
        names = [name for name, array in self.ranked.variables.items() if array.dims == ("rank",)]
        count = min(self.ranked.sizes["rank"], OTHERS + 2)
        return [{str(name): self.ranked[name].values[n].item() for name in names} for n in range(count)]

    @property
    def best(self) -> Row:
        """The best design."""
        return self.rows[0]

    @property
    def clamped(self) -> bool:
        """Whether friction locks the structure of the best design to its base."""
        return is_clamped(self.best)

    @property
    def nearly_clamped(self) -> bool:
        """Whether friction nearly clamps the structure in the best design, although the particle strikes.

        The property is False if a force excites the structure, or if the best design is not recommended.
        """
        based = excitation_of(self.cube) != "force"
        return (
            based and self.lead is self.best and float(self.best["impact_share"]) > 0 and _is_held(self.best)
        )

    @property
    def lead(self) -> Row:
        """The recommended design: the best design or, if friction clamps that design, the best design with impacts."""
        return self.active if self.active is not None and self.clamped else self.best

    @property
    def striking(self) -> Row | None:
        """The best design with impacts, if the recommended design has no impacts; otherwise None."""
        return self.active if self.lead is self.best and self.best["impact_share"] == 0 else None

    @cached_property
    def alone(self) -> Row | None:
        """The first design with friction and without impacts that is at most a tenth worse than the best design.

        None if there is no such design, or if the best design has no impacts.
        """
        if self.lead is not self.best or not self.best["impact_share"] > 0:
            return None
        columns = {str(name): self.ranked[name].values for name in self.best}
        near = (columns["impact_share"] == 0) & (columns["friction_ratio"] > 0)
        near &= columns["value"] <= self.best["value"] * (1 + LOSS)
        rows = ({name: column[n].item() for name, column in columns.items()} for n in np.flatnonzero(near))
        # friction that clamps the structure is no damper
        return next((row for row in rows if not _is_held(row)), None)

    @property
    def others(self) -> list[Row]:
        """The designs that follow the recommended design in the ranking, at most `OTHERS`."""
        lead = self.lead
        return [
            row
            for row in self.rows[1:]
            if row["value"] >= lead["value"] and any(row[name] != lead[name] for name in self.question.design)
        ][:OTHERS]

    @cached_property
    def lead_flat(self) -> list[dict[str, Any]]:
        """The result of `flatness.flatness` around the recommended design.

        The list is empty if another cube may hold the design.
        """
        if self.lead is self.best:
            return self.flat
        if self.homes:
            return []
        place = self.question.place_of(self.lead, self.cube)
        return flatness(self.cube, self.question, place, float(self.lead["value"]))

    @cached_property
    def linear(self) -> LinearPeaks:
        """The peaks with a tuned mass damper of the same mass, and without any damper; NaN unless peaks are judged."""
        if self.question.objective != "peak":
            return LinearPeaks()
        zeta, mass = float(self.lead["damping_ratio"]), float(self.lead["mass_ratio"])
        return LinearPeaks.over(self.question.frequencies, [zeta], mass, excitation_of(self.cube))

    @cached_property
    def peaks(self) -> list[Note]:
        """Notes on peaks that may lie between the judged frequencies."""
        return hidden_peaks(self.cube, self.question, self.ranked, self.lead, self.homes)

    @property
    def home(self) -> "xr.Dataset":
        """The cube that holds the recommended design."""
        return self.homes[str(self.lead["study"])] if self.homes else self.cube

    @cached_property
    def unsure(self) -> Note | None:
        """The note on a hidden peak, if that peak may be higher than the value of another damper."""
        note = next((each for each in self.peaks if each.values["recommended"]), None)
        rivals = [float(row["value"]) for row in self.others]
        rivals += [self.linear.tuned] if math.isfinite(self.linear.tuned) else []
        if note is None or not rivals or self.linear.beats(self.lead["value"]):
            return None
        return note if hidden_of(self.home, self.question.frequencies, self.lead, min(rivals)).any() else None

    @cached_property
    def acceleration_g(self) -> float:
        """The largest acceleration of the structure with the recommended design, in g; NaN if unknown."""
        return acceleration_of(self.lead, self.question, self.home)

    @property
    def complete(self) -> float:
        """Computed share of the designs."""
        return float(self.ranked.attrs["complete"])

    @cached_property
    def notes(self) -> list[Note]:
        """All remarks, as `Note` objects with values in ratios."""
        best, lead, size = self.best, self.lead, self.question.frequencies.size
        notes = []
        if size == 1:
            at = float(self.question.frequencies[0])
            computed = self.cube.sizes[FREQUENCY] == 1
            notes.append(Note("one_frequency", "danger", {FREQUENCY: at, "computed": computed}))
        if self.clamped:
            notes.append(
                Note("clamped", "danger", {"value": best["value"], "locked_share": best["locked_share"]})
            )
        if self.nearly_clamped:
            notes.append(Note("nearly_clamped", "danger", {"locked_share": lead["locked_share"]}))
        if self.alone is not None:
            values = {name: self.alone[name] for name in ("value", "friction_ratio")}
            notes.append(Note("friction_alone", "hint", values))
        if self.linear.beats(lead["value"]):
            notes.append(self.linear.note())
        notes.extend(self.peaks)
        if self.complete < 1:
            notes.append(Note("incomplete", "danger", {"complete": self.complete}))
        if cut := 0 if self.homes else _cut_off(self.cube, self.question, best):
            notes.append(Note("cut_off", "caution", {"responses": cut, "of": size}))
        ends = _ends(self.cube, self.flat, best)
        if ends:
            notes.append(Note("end_of_range", "hint", ends))
        for kind, flag in (("neighbourhood_unknown", "unknown"), ("rugged", "worse")):
            where = [entry["dimension"] for entry in self.flat if entry[flag]]
            if where:
                notes.append(Note(kind, "caution", {"dimensions": where}))
        error, value = float(best["error"]), float(best["value"])
        if value > 0 and error > UNRESOLVED * value:
            notes.append(Note("error", "caution", {"share": error / value}))
        return notes

    def doubts(self, phrases: Phrases) -> list[dict[str, str]]:
        """Return the notes that cast doubt on the best value, the most serious note first."""
        by_kind = {note.kind: note for note in self.notes}
        return [
            {"kind": kind, "sentence": sentence_of(by_kind[kind], phrases)}
            for kind in DOUBTS
            if kind in by_kind
        ]

    def brief(self, phrases: Phrases) -> Brief:
        """Write the short answer."""
        kinds = {note.kind: note for note in self.notes}
        undecided = [kinds[kind] for kind in ("incomplete", "one_frequency") if kind in kinds]
        if undecided:
            return self._undecided(undecided, phrases)
        damper, decision = self._decision(phrases)
        sentences = []
        if self.unsure is not None:
            sentences.append(
                f"Not known which damper is best: {PEAK_BETWEEN[:1].lower()}{PEAK_BETWEEN[1:-1]}; compute "
                f"{self.unsure.values['num']:,} frequencies."
            )
        sentences.append(decision)
        ours = damper != "tuned_mass_damper"
        if ours and "nearly_clamped" in kinds:
            sentences.append(sentence_of(kinds["nearly_clamped"], phrases))
        if self.unsure is None and any(peak.values["recommended"] for peak in self.peaks):
            sentences.append(PEAK_BETWEEN)
        if "cut_off" in kinds and self.lead is self.best:
            sentences.append(sentence_of(kinds["cut_off"], phrases))
        if ours and "friction_alone" in kinds:
            sentences.append(sentence_of(kinds["friction_alone"], phrases))
        sentences.append(self._breaks(phrases))
        return Brief(
            None if self.unsure else damper,
            tuple(sentences),
            tuple(self._rows(damper, phrases)),
            self._next(phrases),
        )

    def _undecided(self, why: list[Note], phrases: Phrases) -> Brief:
        """Say why nothing is recommended, and name the best design so far."""
        least, first = "least", why[0].values
        following = command("run", name_of(self.cube))
        if self.complete < 1:
            least += " so far"
        else:
            least += f" at {phrases.equal(FREQUENCY, first[FREQUENCY], '.4g')}"
            band = "judge by the peak over the band (--objective peak)."
            following = say_next(phrases) if first["computed"] else band
        rows = [(least, self._value(self.lead, phrases), self._design(self.lead, phrases, True))]
        rows += self._idle_row(phrases) + self._linear_rows(phrases) + self._acceleration()
        return Brief(None, tuple(sentence_of(each, phrases) for each in why), tuple(rows), following)

    def _decision(self, phrases: Phrases) -> tuple[Damper, str]:
        lead = self.lead
        value, design = self._value(lead, phrases), self._design(lead, phrases)
        acts = lead["impact_share"] > 0 or math.isnan(lead["impact_share"])
        rubs = float(lead["friction_ratio"]) > 0
        own = damper_of(acts, rubs)
        if self.linear.beats(lead["value"]):
            mass = phrases.equal("mass_ratio", lead["mass_ratio"], ".3g")
            peak = phrases.value(AMPLITUDE, self.linear.tuned, ".3g")
            return (
                "tuned_mass_damper",
                f"A tuned mass damper of {mass} does better, {peak}; the study's best is {value} at {design}.",
            )
        if self.clamped and lead is self.best:
            return (
                own,
                f"The best design clamps the structure to its base by friction: {value} at {design}. Nothing is damped there.",
            )
        if acts:
            by = " that works by impacts" if lead is not self.best else ""
            best = "Best damper" if self.unsure is None else "So far the best damper"
            return own, f"{best}{by}: {self._built(phrases)}. {self._reached(value, phrases)}"
        if not rubs:
            return own, f"The particle does nothing and there is no friction: {value} at {design}."
        if self.unsure is not None:
            return own, f"So far friction alone does best, {value} at {design}."
        return own, f"No particle needed: friction alone does best, {value} at {design}."

    def _built(self, phrases: Phrases) -> str:
        """Name all values that a builder of the recommended damper needs, including fixed values."""
        varied = [name for name in self.question.design if self.cube.sizes[name] > 1 and name not in BUILT]
        return ", ".join(phrases.equal(name, self.lead[name], ".3g") for name in (*BUILT, *varied))

    def _reached(self, value: str, phrases: Phrases) -> str:
        """State the value that the recommended damper reaches."""
        if self.question.objective == "peak":
            r = self.question.frequencies
            span = phrases.span(FREQUENCY, float(r[0]), float(r[-1]), ".4g")
            return f"That keeps {phrases.symbol(AMPLITUDE)} within {value} at {r.size:,} frequencies, {span}."
        return f"It reaches {value}."

    def _breaks(self, phrases: Phrases) -> str:
        """Name parameters along which one grid step makes the value much worse, and those at the end of an axis."""
        rugged = [phrases.symbol(entry["dimension"]) for entry in self.lead_flat if entry["worse"]]
        ends = [phrases.symbol(name) for name in _ends(self.cube, self.lead_flat, self.lead)]
        parts = [f"one grid step in {listed(rugged)} costs more than 10 %"] if rugged else []
        parts += [f"it lies at the end of {listed(ends)}"] if ends else []
        text = "; ".join(parts)
        return f"{text[:1].upper()}{text[1:]}." if text else ""

    def _rows(self, damper: Damper, phrases: Phrases) -> list[tuple[str, str, str]]:
        rows = self._idle_row(phrases)
        if self.striking is not None and not any(row["impact_share"] > 0 for row in self.others):
            row = self.striking
            rows.append(("best with impacts", self._value(row, phrases), self._design(row, phrases)))
        # without impacts, designs that differ only in the particle are the same design
        same = self._design(self.lead, phrases)
        others = [row for row in self.others if row["impact_share"] or self._design(row, phrases) != same]
        for place, row in zip(PLACES[1:], others, strict=False):
            idle = ", no impacts" if row["impact_share"] == 0 < self.lead["impact_share"] else ""
            name = place if row["value"] > self.lead["value"] else EQUAL
            rows.append((name, self._value(row, phrases), self._design(row, phrases) + idle))
        beaten = damper == "tuned_mass_damper"
        return rows + self._linear_rows(phrases, beaten) + self._acceleration(beaten)

    def _linear_rows(self, phrases: Phrases, beaten: bool = False) -> list[tuple[str, str, str]]:
        """Return the rows of the tuned mass damper and of the structure without damper."""
        return self.linear.rows(
            lambda peak: phrases.value(AMPLITUDE, peak, ".3g"),
            lambda mass: phrases.equal("mass_ratio", mass, ".3g"),
            beaten,
        )

    def _acceleration(self, beaten: bool = False) -> list[tuple[str, str, str]]:
        """Return the row with the acceleration of the structure and the assumptions about the cavity."""
        return acceleration_rows(self.acceleration_g, self.cube, self.lead["impact_share"] > 0, beaten)

    def _idle_row(self, phrases: Phrases) -> list[tuple[str, str, str]]:
        if self.lead is self.best:
            return []
        name = "clamped to its base" if self.clamped else "without impacts"
        return [(name, self._value(self.best, phrases), self._design(self.best, phrases))]

    def _next(self, phrases: Phrases) -> str:
        study = name_of(self.cube)
        for hidden in self.peaks:
            if hidden.values["recommended"]:
                return f"compute {advised_axis(hidden.values, phrases)}."
        ends = _ends(self.cube, self.lead_flat, self.lead)
        if ends:
            return say_beyond(ends, phrases)
        return command("refine" if any(entry["worse"] for entry in self.lead_flat) else "tmd", study)

    def _value(self, row: Row, phrases: Phrases) -> str:
        return phrases.measured(float(row["value"]), float(row["error"]), ".3g")

    def _design(self, row: Row, phrases: Phrases, acts: bool = False) -> str:
        """Name the varying parameters of a design.

        If the particle has no impacts, its parameters are named only if `acts` is True. In a study of one design,
        all parameters are named.
        """
        varied = [name for name in self.question.design if self.cube.sizes[name] > 1]
        varied = [
            name for name in self.question.design if name in (varied or BUILT) or name == "friction_ratio"
        ]
        if row["impact_share"] == 0 and not acts:
            varied = [name for name in varied if name not in OF_PARTICLE]
        return ", ".join(phrases.equal(name, row[name], ".3g") for name in varied)


def none_left(cube: "xr.Dataset", question: DesignQuestion, tally: Mapping[str, Any]) -> Fault:
    """Say why no design could be ranked, and what to do about the most frequent reason."""
    total, failed = int(tally["designs"]), int(tally["failed"])
    status = cube["status"].isel(question.axes).values if failed else np.zeros(0)
    if failed == total and (status == Status.UNBOUNDED).any():
        told = "The response of every design grows without bound: nothing dissipates the energy that the excitation supplies."
        advice = "give the structure damping, or friction above γ_F = π/4"
        return Fault("damping_ratio", "0", "damping or friction", advice, told)
    reason = max(REASONS, key=lambda each: int(tally[each]))
    field, allowed, advice = {
        "incomplete": (
            "study",
            "a design that is computed at every judged frequency",
            "compute the rest first",
        ),
        "failed": (
            "study",
            "a design with a response at every judged frequency",
            "the record of the study says why they failed",
        ),
        "locked": ("exclude_locked", "false", "rank designs that are locked near resonance, too"),
        "too_fast": ("max_impact_speed", "a speed that a design keeps", "allow faster impacts"),
        "outside": (
            "ranges",
            "a range that a design keeps",
            f"widen the range of {', '.join(question.limits)}",
        ),
    }[reason]
    why = ", ".join(f"{int(tally[name]):,} {words}" for name, words in REASONS.items() if tally[name])
    told = f"None of the {total:,} designs qualifies: {why}."
    return Fault(
        field, f"{int(tally[reason]):,} of {total:,} designs {REASONS[reason]}", allowed, advice, told
    )


def say_next(phrases: Phrases) -> str:
    """Name the frequencies to compute next for a study with one frequency."""
    return f"compute {advised_axis(NEXT_BAND, phrases)}."


def _ends(cube: "xr.Dataset", flat: list[dict[str, Any]], design: Row) -> dict[str, list[Any]]:
    """Return the ends of axes at which a design lies.

    An axis is left out if its parameter has no effect on the response, so that all values are equally good.
    """
    ends = {}
    for entry in flat:
        name, value = entry["dimension"], entry["value"]
        end = end_of(cube[name].values, value, name)
        level = entry["below"] is None and entry["above"] is None
        if end and not (level and _independent(design, name)):
            ends[name] = [end, value]
    return ends


def _cut_off(cube: "xr.Dataset", question: DesignQuestion, best: Row) -> int:
    """Count the runs of a design that ended at the cycle limit, before they reached the tolerance."""
    place = question.place_of(best, cube)
    status = cube["status"].isel({**place, FREQUENCY: question.axes[FREQUENCY]}).values
    return int((status == Status.MAX_CYCLES).sum())


def _independent(design: Row, name: str) -> bool:
    """Whether the parameter `name` has no effect on the response of a design.

    If friction clamps the structure, no parameter has an effect. Without impacts, no parameter of the
    particle has an effect.
    """
    return is_clamped(design) or (design["impact_share"] == 0 and name in OF_PARTICLE)
