"""The short answer to whether a study's damper or a tuned mass damper is better, and whether this is certain."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.amplitudes import RATIOS_OF
from damperlab.studies.answers.excited import definition_of, excitation_of, name_of
from damperlab.studies.answers.hidden_peak import hidden, hidden_note, may_hide
from damperlab.studies.answers.judging import may_strike
from damperlab.studies.answers.linear_peaks import UNBOUNDED
from damperlab.studies.answers.notes import advised_axis, sentence_of
from damperlab.studies.answers.phrases import AMPLITUDE, FREQUENCY, Phrases
from damperlab.studies.answers.verdict import is_clamped, say_next
from damperlab.studies.brief import Brief, Damper, Note, command, damper_of
from damperlab.studies.cavity import left_open
from damperlab.studies.variables import ResponseClass, Status
from damperlab.studies.vocabulary import OF_PARTICLE

if TYPE_CHECKING:
    import xarray as xr

DETUNING = 0.02
"""An answer suggests a further comparison with this detuning of the tuned mass damper.

It makes no such suggestion if its own tuned mass damper is detuned by at least as much.
"""


def is_judged(answer: "xr.Dataset") -> bool:
    """Whether it is known which damper has the lower peak over the band.

    One value above the tuned mass damper's peak proves that the study's peak is higher. The study's peak is known
    to be lower if every frequency has a value, and no response between two frequencies can reach the tuned mass
    damper's peak. Only a resonance between two frequencies can reach that peak, or a flank where the particle
    begins to strike.

    Parameters
    ----------
    answer : Dataset
        The answer of `tmd_comparison`, with the peaks and their `ratio`.
    """
    if answer.sizes[FREQUENCY] == 1 or np.isnan(answer.attrs["ratio"]):
        return False
    hybrid = answer["hybrid"].values
    if answer.attrs["ratio"] > 1 or not np.isfinite(hybrid).all():
        return bool(answer.attrs["ratio"] > 1)
    peak = answer.attrs["tmd_peak"]
    resonates = may_hide(answer[FREQUENCY].values, hybrid, peak, float(answer["mass_ratio"]))
    return not (resonates or _hidden(answer, peak).any())


def notes_of(cube: "xr.Dataset", answer: "xr.Dataset") -> list[Note]:
    """Return notes on the facts that limit or change the comparison."""
    found, r = answer.attrs, answer[FREQUENCY].values
    notes = []
    if r.size == 1:
        only = {FREQUENCY: float(r[0]), "computed": cube.sizes[FREQUENCY] == 1}
        notes.append(Note("one_frequency", "danger", only))
    if np.isinf(found["hybrid_peak"]):
        notes.append(Note("unbounded", "danger", {FREQUENCY: found["hybrid_peak_at"]}))
    if _is_clamped(answer):
        notes.append(Note("clamped", "danger", {"value": found["hybrid_peak"]}))
    unknown = ~np.isfinite(answer["hybrid"].values)
    if unknown.any():
        waiting = int((answer["status"].values[unknown] == Status.NOT_COMPUTED).sum())
        rest = int(unknown.sum()) - waiting
        notes.append(Note("missing", "caution", {"waiting": waiting, "failed": rest, "of": r.size}))
    notes += hidden_note(r, _hidden(answer), np.array([float(answer["damping_ratio"])]))
    if found["excitation"] != excitation_of(cube):
        notes.append(Note("other_excitation", "caution"))
    if float(answer["mass_ratio"]) != found["tmd_mass_ratio"]:
        masses = {"mass_ratio": float(answer["mass_ratio"]), "tmd_mass_ratio": found["tmd_mass_ratio"]}
        notes.append(Note("masses_differ", "hint", masses))
    return notes


def brief_of(
    cube: "xr.Dataset", answer: "xr.Dataset", varied: Mapping[str, float], known: list[Note], phrases: Phrases
) -> Brief:
    """Name the damper with the lower peak over the band, or say why this damper is not known.

    Parameters
    ----------
    cube : Dataset
        The cube of the study.
    answer : Dataset
        The answer of `tmd_comparison`, with the peaks, their `ratio`, and `judged`.
    varied : mapping of float
        The varying parameters of the study's design.
    known : list of Note
        The notes from `notes_of`.
    phrases : Phrases
        The names and units of quantities.
    """
    found: dict[str, Any] = answer.attrs
    notes = {each.kind: each for each in known}
    study = name_of(cube)
    if "one_frequency" in notes:
        return Brief(None, (sentence_of(notes["one_frequency"], phrases),), (), say_next(phrases))
    ours = phrases.value(AMPLITUDE, found["hybrid_peak"], ".3g")
    theirs = phrases.value(AMPLITUDE, found["tmd_peak"], ".3g")
    missing = sentence_of(notes["missing"], phrases) if "missing" in notes else ""
    if np.isnan(found["ratio"]):
        told = f"No value of this damper's curve is known: {missing}"
        return Brief(None, (told,), (), command("run", study))
    damper: Damper | None = None
    following = command("tmd", study, f"--detuning {DETUNING}")
    if max(abs(found["detuning"]), abs(found["damping_detuning"])) >= DETUNING:
        following = command("report", study, "-o report.html")
    if np.isinf(found["hybrid_peak"]):
        at = phrases.equal(FREQUENCY, found["hybrid_peak_at"])
        damper, ours = "tuned_mass_damper", UNBOUNDED
        told = (
            f"Use the tuned mass damper, {theirs}: with the study's damper the response {UNBOUNDED} at {at}."
        )
    elif not found["judged"]:
        why = missing or "between the frequencies computed the study's peak may be higher."
        told = f"Not known which is better: the study's damper reaches {ours} so far, a tuned mass damper {theirs}; {why}"
        r = answer[FREQUENCY].values
        twice = {"start": float(r[0]), "stop": float(r[-1]), "num": 2 * r.size - 1}
        following = command("run", study) if missing else f"compute {advised_axis(twice, phrases)}."
    else:
        lower = abs(1 - found["ratio"]) if found["ratio"] < 1 else 1 - 1 / found["ratio"]
        apart = f"{100 * lower:.2g} % lower"
        own = damper_of(_strikes(answer), float(_friction_of(answer)) > 0)
        damper = own if found["ratio"] < 1 else "tuned_mass_damper"
        better, other = (ours, theirs) if found["ratio"] < 1 else (theirs, ours)
        least = "at least " if missing else ""
        told = f"The study's damper does better than a tuned one: {better} against {other}, {apart}."
        if "clamped" in notes:
            told = (
                f"Friction of the study's damper clamps the structure to its base, {ours}: nothing is damped there. "
                f"A tuned mass damper reaches {theirs}."
            )
        if damper == "tuned_mass_damper":
            told = f"Use a tuned mass damper, {_tuned(found, phrases)}: {better} against {least}{other}, {apart}."
    hides = so_far = ""
    if "incomplete" in notes:
        damper, so_far = None, sentence_of(notes["incomplete"], phrases)
        told = f"So far the study's best reaches {ours}, a tuned mass damper {theirs}."
        following = command("run", study)
    elif "hidden_peak" in notes:
        if found["judged"]:
            hides = "Between the frequencies computed the study's peak may be more than a tenth higher."
        following = f"compute {advised_axis(notes['hidden_peak'].values, phrases)}."
    rows = _rows(answer, varied, (ours, theirs), phrases)
    if _strikes(answer) and (cavity := left_open(definition_of(cube))):
        rows += (("assumed", "", f"{', '.join(cavity)} cavity of the study's damper"),)
    return Brief(damper, (so_far, told, hides), rows, following)


def _is_clamped(answer: "xr.Dataset") -> bool:
    """Whether friction of the study's damper locks the structure to its base."""
    if "response_class" not in answer:
        return False
    locked = float((answer["response_class"].values == ResponseClass.LOCKED).mean())
    value = answer.attrs["hybrid_peak"]
    return is_clamped({"value": value, "locked_share": locked, "impact_share": float(_strikes(answer))})


def _strikes(answer: "xr.Dataset") -> bool:
    """Whether the study's damper has a particle that strikes, as far as is known."""
    kinds = answer.get("response_class")
    return float(answer["mass_ratio"]) > 0 and (kinds is None or bool(may_strike(kinds.values).any()))


def _friction_of(answer: "xr.Dataset") -> "xr.DataArray":
    return answer["friction_ratio" if "friction_ratio" in answer.coords else "friction_force_n"]


def _rows(
    answer: "xr.Dataset", varied: Mapping[str, float], peaks: tuple[str, str], phrases: Phrases
) -> tuple[tuple[str, str, str], ...]:
    found: dict[str, Any] = answer.attrs
    named = dict(varied)
    if not _strikes(answer):  # without impacts, only friction dissipates energy in the damper
        named = {
            name: value for name, value in varied.items() if RATIOS_OF.get(name, name) not in OF_PARTICLE
        }
        friction = _friction_of(answer)
        named[str(friction.name)] = float(friction)
    design = ", ".join(phrases.equal(name, value, ".3g") for name, value in named.items())
    highest = max(found["exact"]["no_damper"])
    bare = phrases.value(AMPLITUDE, highest, ".3g") if np.isfinite(highest) else UNBOUNDED
    rows = [
        ("study's damper", peaks[0], design),
        ("tuned mass damper", peaks[1], _tuned(found, phrases)),
        ("without damper", bare, ""),
    ]
    better = ", ".join(phrases.span(FREQUENCY, low, high, ".4g") for low, high in found["hybrid_better"])
    if found["judged"]:
        rows.insert(2, ("study's is better", "", f"at {better}" if better else "nowhere"))
    if found["tmd_peak_everywhere"] > found["tmd_peak"] * (1 + 1e-9):
        beyond = phrases.value(AMPLITUDE, found["tmd_peak_everywhere"], ".3g")
        rows.append(("tuned mass damper", beyond, "outside the band"))
    if float(answer["mass_ratio"]) != found["tmd_mass_ratio"]:
        rows.append(
            (
                "the masses differ",
                phrases.value("mass_ratio", float(answer["mass_ratio"]), ".3g"),
                "of the study's damper",
            )
        )
    return tuple(rows)


def _tuned(found: Mapping[str, Any], phrases: Phrases) -> str:
    mass = phrases.equal("mass_ratio", found["tmd_mass_ratio"], ".3g")
    own = phrases.value(FREQUENCY, found["tmd_tuning"], ".4g")
    tuned = f"f = {own}" if phrases.unit(FREQUENCY) else f"tuned to {own} ω_n"
    return f"{mass}, {tuned}, ζ = {found['tmd_damping_ratio']:.2g}"


def _hidden(answer: "xr.Dataset", level: float | None = None) -> NDArray[np.bool_]:
    """Mark the intervals in which a peak may be hidden (see `hidden`). If a value is unknown, mark no interval."""
    hybrid, r = answer["hybrid"].values, answer[FREQUENCY].values
    if r.size == 1 or not np.isfinite(hybrid).all():
        return np.zeros((1, r.size - 1), np.bool_)
    kinds = answer["response_class"].values if "response_class" in answer else np.full(r.size, -1, np.int8)
    zeta, beta = (np.array([float(answer[name])]) for name in ("damping_ratio", "mass_ratio"))
    return hidden(r, hybrid[None], kinds[None], zeta, beta, level)
