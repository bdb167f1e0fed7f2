"""Rank the dampers of a ground-motion suite, or of a study over base amplitudes, by the worst case."""

from collections.abc import Callable, Mapping, Sequence
from math import isfinite, nan, tau
from typing import TYPE_CHECKING, Any

import numpy as np

from damperlab.studies.amplitudes import AMPLITUDE, CONSTANT
from damperlab.studies.answers.comparing import Found, least
from damperlab.studies.answers.design_question import axes_within
from damperlab.studies.answers.excited import amplitude_called, definition_of, excitation_of, name_of
from damperlab.studies.answers.flatness import ends_of_damper, say_beyond
from damperlab.studies.answers.judging import leave_out, say_left_out
from damperlab.studies.answers.largest_acceleration import acceleration_g, acceleration_rows
from damperlab.studies.answers.linear_peaks import LinearPeaks
from damperlab.studies.answers.nearness import nearest_place
from damperlab.studies.answers.notes import share
from damperlab.studies.answers.phrases import Phrases
from damperlab.studies.answers.query_fault import check_question, refused
from damperlab.studies.answers.selection import (
    check_quantity,
    completeness,
    count,
    dimensions_of,
    main_metric,
    require_stored,
)
from damperlab.studies.answers.slab import Slab, slabs_of
from damperlab.studies.brief import (
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
from damperlab.studies.faults import counted, describe, listing
from damperlab.studies.ground.brief import HELD
from damperlab.studies.ground.builtin import whole_id
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.variables import RECORD
from damperlab.studies.kinds import AMPLITUDES, SUITE, kind_of
from damperlab.studies.questions import Judging, Listed, Ranking
from damperlab.studies.tmd.absorber import NO_DAMPER, Absorber
from damperlab.studies.tmd.tunings import tuned
from damperlab.studies.tmd.under_record import MEASURES, response_under
from damperlab.studies.variables import ResponseClass, Status

if TYPE_CHECKING:
    import xarray as xr

Motions = Callable[[], Mapping[str, GroundMotion]]
"""Function that returns the records of a ground-motion suite, by their ids; none if they cannot be read."""
_MET = {"frequency_ratio": "frequencies", "damping_ratio": "damping ratios of the structure"}
_LEFT_OUT = {
    "failed": "with a case that failed",
    "incomplete": "not computed yet",
    "locked": "locked to the base near resonance at every base amplitude",
}


def require_harmonic(dimensions: Sequence[str], asked: str, amplitudes: bool = False) -> None:
    """Raise `QueryFault` for a ground-motion suite, and for a study over base amplitudes unless `amplitudes` is set.

    Parameters
    ----------
    dimensions : sequence of str
        The dimensions of the study.
    asked : str
        The name of the question.
    amplitudes : bool
        Whether a study over base amplitudes can answer the question too.
    """
    kind = kind_of(dimensions)
    if kind is AMPLITUDES and not amplitudes:
        raise refused(
            "study",
            f"{kind.words}, over {listing(dimensions)}",
            f"a study with one base amplitude for {asked}",
            _instead(asked),
            f"{asked} needs a study with one base amplitude, but this is {kind.words}.",
        )
    if kind is SUITE:
        raise refused(
            "study",
            f"a ground-motion suite, over {listing(dimensions)}",
            f"a study of the response to a harmonic base for {asked}",
            "ask for a map over two of its dimensions, for its optimal designs, or for an export",
            f"{asked} needs the response to a harmonic base, but this is a ground-motion suite.",
        )


def _instead(asked: str) -> str:
    """Say what to ask of a study over base amplitudes instead of the refused question."""
    if asked in ("refine", "follow-ups"):
        return (
            "submit it again with finer axes of clearance_m and friction_force_n around its best damper, or with one base "
            "amplitude; points that are known are not computed again"
        )
    return "ask for a map, a response or its optimal designs, or submit the study with one base amplitude"


def worst_cases(
    cube: "xr.Dataset", judging: Judging = Judging(), ranking: Ranking = Ranking()
) -> "xr.Dataset":
    """Rank dampers by their worst case: over the records, scales and structures of a suite, or over base amplitudes.

    Parameters
    ----------
    cube : Dataset
        The cube of a ground-motion suite or of a study over base amplitudes, read slab by slab.
    judging : Judging
        `ranges` limits the ranked dampers and the cases. `exclude_locked` leaves out dampers whose friction locks the
        mass to its base near resonance at every base amplitude.
    ranking : Ranking
        `metric` is the criterion, of which smaller values are better; by default the main metric of the study. `records`
        are the records over which the worst case is taken, each by its id or by the name of an earthquake.

    Returns
    -------
    Dataset
        Dimension rank, counted from 1. The coordinates are the four dimensions of the damper, and the dimensions of its
        worst case. The variables are `value` and, if they are stored, further results of the worst case: `growth` of
        the perturbed starts, `error` of an amplitude, and `response_class`. A damper with a case that failed or was not
        computed is left out. Attributes: `metric`, `designs` (number of all dampers in the ranges), `failed`,
        `incomplete`, `locked`, `complete`, `points`, `points_failed`, and `note`, a description in words.

    Raises
    ------
    QueryFault
        If an argument is not allowed, or no grid point is in a range.
    """
    import xarray as xr

    metric = ranking.metric or main_metric(cube)
    check_quantity(cube, metric, "which have no order, so dampers cannot be ranked by it")
    check_question(Listed(ranking.top))
    damper = kind_of(cube.sizes).designs
    counting = _counting(cube, judging, ranking)
    if judging.exclude_locked:
        require_stored(cube, "exclude_locked", "response_class")
    beside = _beside(cube, metric)
    best: Found = {}
    tally = dict.fromkeys(("designs", *_LEFT_OUT), 0)
    counts = np.zeros(3, np.int64)
    for slab in slabs_of(cube, counting, damper):
        status = slab.read("status")
        counts += count(status)
        keep = np.ones(len(status), bool)
        tally["designs"] += keep.size
        keep = leave_out(tally, "failed", keep, (status > Status.MAX_CYCLES).any(axis=1))
        keep = leave_out(tally, "incomplete", keep, (status == Status.NOT_COMPUTED).any(axis=1))
        if judging.exclude_locked:
            keep = leave_out(tally, "locked", keep, _locked(slab))
        rows = np.flatnonzero(keep)
        values = slab.read(metric)[rows].astype(float)
        place = np.where(np.isnan(values), -np.inf, values).argmax(axis=1)
        found: Found = {"value": values[np.arange(rows.size), place]}
        found |= {name: slab.read(source)[rows, place] for name, source in beside.items()}
        best = least(best, found | slab.designs_at(rows) | slab.cases_at(place), ranking.top)
    dimensions = (*damper, *(name for name in dimensions_of(cube) if name not in damper))
    columns: dict[str, Any] = {
        name: ("rank", cube[name].values[best[name]], cube[name].attrs) for name in dimensions
    }
    data = {"value": ("rank", best["value"], dict(cube[metric].attrs))}
    data |= {name: ("rank", best[name], dict(cube[source].attrs)) for name, source in beside.items()}
    ranked = best["value"].size
    if not judging.exclude_locked:
        del tally["locked"]
    attributes = {"metric": metric, **tally, **completeness(counts)}
    attributes["note"] = _note(cube.isel(counting), metric, tally, ranked)
    return xr.Dataset(data, {"rank": np.arange(1, ranked + 1), **columns}, attributes)


def worst_case_designs(
    cube: "xr.Dataset",
    judging: Judging = Judging(),
    ranking: Ranking = Ranking(),
    motions: Motions | None = None,
) -> "xr.Dataset":
    """Rank dampers as `worst_cases` does, and describe the best damper.

    Parameters
    ----------
    cube, judging, ranking
        As in `worst_cases`.
    motions : callable, optional
        As in `ranking.ranked_designs`.

    Returns
    -------
    Dataset
        The answer of `worst_cases` with further attributes: `brief` (the short answer), `verdict` (the sentences of the
        short answer) and `notes` (all remarks as data). A study over base amplitudes also has `acceleration_g`, the
        largest acceleration of the structure with the best damper, if this acceleration is known.
    """
    answer = worst_cases(cube, judging, ranking)
    damper, counting = kind_of(cube.sizes).designs, _counting(cube, judging, ranking)
    ends: dict[str, list[Any]] = {}
    linear, notes, clamped = LinearPeaks(), [], False
    if answer.sizes["rank"]:
        place = {name: nearest_place(cube[name].values, answer[name].values[0]) for name in damper}
        clamped = _clamps(cube, {**counting, **place})
        # the complete axes are used, including values outside the ranges; a clamped structure has no best values
        ends = {} if clamped else ends_of_damper(cube, answer.attrs["metric"], counting, place)
        if kind_of(cube.sizes) is AMPLITUDES:
            most = acceleration_g(cube, {**counting, **place})
            answer.attrs |= {"acceleration_g": most} if isfinite(most) else {}
            linear = _linear_peaks(cube.isel(counting), answer)
        elif motions is not None:
            linear = _linear_under_records(cube.isel(counting), answer, motions)
        notes += [Note("clamped", "danger", {"value": answer["value"].values[0].item()})] if clamped else []
        notes += [Note("end_of_range", "hint", ends)] if ends else []
        notes += [linear.note()] if linear.beats(float(answer["value"].values[0])) else []
    answer.attrs["notes"] = notes_document(notes)
    answer.attrs["brief"] = _brief(cube, answer, damper, ends, linear, clamped).document()
    answer.attrs["verdict"] = answer.attrs["brief"]["sentences"]
    return answer


def _beside(part: "xr.Dataset", metric: str) -> dict[str, str]:
    """Return the results that accompany a worst case, as a mapping from their names to variables of the cube."""
    found = {"growth": "growth", "response_class": "response_class"}
    if metric in ("amplitude_ratio", "amplitude_m"):
        found["error"] = metric.replace("amplitude", "amplitude_error").removesuffix("_ratio")
    return {name: source for name, source in found.items() if source in part.data_vars and source != metric}


def _clamps(cube: "xr.Dataset", place: Mapping[str, Any]) -> bool:
    """Whether the friction of a damper holds the structure to its base throughout every case."""
    if "response_class" in cube:
        return bool((cube["response_class"].isel(place).values == ResponseClass.LOCKED).all())
    return "stick_fraction" in cube and bool((cube["stick_fraction"].isel(place).values >= HELD).all())


def _locked(slab: Slab) -> np.ndarray:
    """Find the dampers that are locked in every case at the frequency nearest resonance."""
    r = slab.cube["frequency_ratio"].values[slab.cases_at(np.arange(slab.extent))["frequency_ratio"]]
    near = np.abs(r - 1.0)
    kinds = slab.read("response_class")[:, near == near.min()]
    return np.asarray((kinds == ResponseClass.LOCKED).all(axis=1))


def _counting(cube: "xr.Dataset", judging: Judging, ranking: Ranking) -> dict[str, np.ndarray]:
    """Return the positions of the ranked dampers and of their cases along every dimension."""
    index = axes_within(cube, judging.ranges)
    if ranking.records is not None:
        known = cube[RECORD].values.tolist()
        for each in ranking.records:
            if whole_id(each) not in known:
                advice = "leave it out to rank over all records"
                raise refused(RECORD, describe(each), f"one or more of {listing(known)}", advice)
        index[RECORD] = np.flatnonzero(np.isin(known, [whole_id(each) for each in ranking.records]))
    return index


def _linear_peaks(met: "xr.Dataset", answer: "xr.Dataset") -> LinearPeaks:
    """Compute the peaks without a damper, and with a tuned mass damper that has the mass of the best damper."""
    metric = answer.attrs["metric"]
    if metric not in ("amplitude_ratio", "amplitude_m"):
        return LinearPeaks()
    in_metres = metric == "amplitude_m"
    # a ratio is relative to the base amplitude at each frequency
    order = CONSTANT.get(definition_of(met).get("physical", {}).get("constant"), 0) if in_metres else 0
    scale = float(met[AMPLITUDE].max()) if in_metres else 1.0
    r, mass = met["frequency_ratio"].values, float(answer["mass_ratio"].values[0])
    return LinearPeaks.over(r, met["damping_ratio"].values.tolist(), mass, excitation_of(met), scale, order)


def _linear_under_records(met: "xr.Dataset", answer: "xr.Dataset", motions: Motions) -> LinearPeaks:
    """Compute the worst cases without a damper, and with a tuned mass damper that has the mass of the best damper.

    The tuned mass damper is tuned for a harmonic base motion. If the suite has several natural frequencies, nothing
    is computed, because it is not known for which structure to tune the damper.
    """
    metric, suite = answer.attrs["metric"], definition_of(met)
    if metric not in MEASURES or met.sizes["natural_frequency_hz"] > 1:
        return LinearPeaks()
    omega = tau * float(met["natural_frequency_hz"][0])
    dampings = met["damping_ratio"].values.tolist()
    scale = float(np.abs(met["scale"].values).max())
    records = motions()
    if not records:
        return LinearPeaks()

    def worst(absorber: Absorber) -> float:
        return max(
            response_under(absorber, zeta, omega, records[record], scale, suite["tail_s"]).measure(metric)
            for record in met[RECORD].values
            for zeta in dampings
        )

    bare = worst(NO_DAMPER)
    mass_ratio = float(answer["particle_mass_kg"].values[0]) / suite["mass_kg"]
    if not 0.0 < mass_ratio < 1.0:
        return LinearPeaks(bare=bare)
    return LinearPeaks(worst(tuned("minimax", mass_ratio, min(dampings))), bare, mass_ratio)


def _brief(
    cube: "xr.Dataset",
    answer: "xr.Dataset",
    damper: tuple[str, ...],
    ends: Mapping[str, list[Any]],
    linear: LinearPeaks,
    clamped: bool,
) -> Brief:
    """Name the best damper, its worst case, and the next best dampers."""
    values = answer["value"].values
    if not np.isfinite(values[:1]).any():
        why = say_left_out(answer.attrs, _LEFT_OUT, "damper")
        following = command("run", name_of(cube)) if answer.attrs["incomplete"] else ""
        return Brief(None, (f"No damper qualifies. {why}".rstrip(),), (), following)
    phrases, metric = Phrases.of(cube), str(answer.attrs["metric"])
    # the dimensions of a suite's dampers are already in SI units
    varied = [name for name in damper if cube.sizes[name] > 1]
    met = [
        str(name) for name in answer.coords if name != "rank" and name not in damper and cube.sizes[name] > 1
    ]

    def valued(value: float) -> str:
        text = phrases.value(metric, value, ".3g")
        if phrases.unit(metric):
            return text
        return f"{text} {answer['value'].attrs.get('units', '1')}".removesuffix(" 1")

    def mass_of(ratio: float) -> str:
        if kind_of(cube.sizes) is SUITE:
            return phrases.equal("particle_mass_kg", float(answer["particle_mass_kg"].values[0]), ".3g")
        return phrases.equal("mass_ratio", ratio, ".3g")

    def spelled(rank: int) -> tuple[str, str, str]:
        row = {str(name): answer[name].values[rank].item() for name in (*varied, *met, "value")}
        value = valued(row["value"])
        where = [row[name] if name == RECORD else phrases.equal(name, row[name], ".3g") for name in met]
        return value, ", ".join(phrases.equal(name, row[name], ".3g") for name in varied), ", ".join(where)

    value, design, where = spelled(0)
    complete = answer.attrs["complete"]
    if complete < 1:
        told = f"Only {share(complete)} of the points are computed, so nothing is recommended yet."
        rows = [("least so far", value, design), *linear.rows(valued, mass_of, False)]
        return Brief(None, (told,), tuple(rows), command("run", name_of(cube)))
    best = f"{design or 'the only one'}. At worst {value}{f', at {where}' if where else ''}."
    beaten = linear.beats(float(values[0]))
    if beaten:
        of = mass_of(linear.mass_ratio)
        best = f"A tuned mass damper of {of} does better: at worst {valued(linear.tuned)}. The study's best: {best}"
    following = say_beyond(ends, phrases)
    sentences = [best if beaten else f"Best damper: {best}"]
    if clamped and not beaten:
        sentences = [f"Friction clamps the structure to its base: nothing is damped. {sentences[0]}"]
        least = phrases.value("friction_force_n", float(answer["friction_force_n"].values[0]), ".3g")
        following = f"{phrases.label('friction_force_n')} below {least}."
    if ends:
        sentences.append(f"It lies at the end of {listed(map(phrases.symbol, ends))}.")
    kind = _kind(answer)
    rows = []
    for rank in range(1, min(int(np.isfinite(values).sum()), len(PLACES))):
        name = PLACES[rank] if values[rank] > values[0] else EQUAL
        rows.append((name, *spelled(rank)[:2]))
    rows += linear.rows(valued, mass_of, beaten)
    acts = kind in ("hybrid", "particle_alone")
    rows += acceleration_rows(answer.attrs.get("acceleration_g", nan), cube, acts, beaten)
    return Brief("tuned_mass_damper" if beaten else kind, tuple(sentences), tuple(rows), following)


def _kind(answer: "xr.Dataset") -> Damper:
    mass = float(answer["mass_ratio" if "mass_ratio" in answer.coords else "particle_mass_kg"].values[0])
    friction = float(answer["friction_force_n"].values[0])
    return damper_of(mass > 0.0, friction > 0.0)


def _note(part: "xr.Dataset", metric: str, said: Mapping[str, Any], ranked: int) -> str:
    met: tuple[str, ...]
    if kind_of(part.sizes) is SUITE:
        structures = part.sizes["natural_frequency_hz"] * part.sizes["damping_ratio"]
        met = (
            counted(part.sizes[RECORD], "record"),
            counted(part.sizes["scale"], "scale"),
            counted(structures, "structure"),
        )
    else:
        met = (counted(part.sizes[AMPLITUDE], amplitude_called(part)),)
        met += tuple(f"{part.sizes[n]} {words}" for n, words in _MET.items() if part.sizes[n] > 1)
    long_name = part[metric].attrs.get("long_name", metric)
    sentences = [
        f"Ranked by the largest {long_name.removeprefix('largest ')} over {', '.join(met)}; smaller is better."
    ]
    sentences.append(say_left_out(said, _LEFT_OUT, "damper"))
    if not ranked:
        sentences.append("No damper is left.")
    return " ".join(filter(None, sentences))
