"""Sentences for the notes of answers, with quantities as ratios or in physical units."""

from collections.abc import Iterable, Mapping
from math import floor
from typing import Any

from damperlab.studies.answers.phrases import AMPLITUDE, FREQUENCY, Phrases
from damperlab.studies.brief import Note, listed
from damperlab.studies.faults import counted

FAR = 4.0
"""Distance between two frequencies, in bandwidths, above which a hidden peak may be far higher."""

Values = Mapping[str, Any]


def sentences_of(notes: Iterable[Note], phrases: Phrases) -> str:
    """Return the sentences of several notes as one text."""
    return " ".join(sentence_of(each, phrases) for each in notes)


def sentence_of(note: Note, phrases: Phrases) -> str:
    """Return the sentence of a note."""
    known = note.values
    match note.kind:
        case "one_frequency":
            only = "was computed" if known["computed"] else "is judged"
            at = phrases.equal(FREQUENCY, known[FREQUENCY], ".10g")
            return f"Only {at} {only}, so nothing is recommended: a damper quiet there may resonate at another frequency."
        case "hidden_peak":
            return _hidden_peak(known, phrases)
        case "nearly_clamped":
            return "Its friction nearly clamps the structure to its base."
        case "friction_alone":
            value = phrases.value(AMPLITUDE, known["value"], ".3g")
            at = phrases.equal("friction_ratio", known["friction_ratio"], ".3g")
            return f"Friction alone does almost as well: {value} at {at}."
        case "cut_off":
            return (
                f"{known['responses']} of the best design's {known['of']} responses ended at `max_cycles`: the error may "
                "be larger than stated."
            )
        case "error":
            return (
                f"The error of the best value is {known['share']:.1%}. Compute the study longer, with a smaller "
                "`steady.tolerance`."
            )
        case "end_of_range":
            return (
                f"The best design lies at the end of {listed(map(phrases.symbol, known))}; a better design may lie "
                "beyond that end."
            )
        case "rugged":
            where = listed(map(phrases.symbol, known["dimensions"]))
            return (
                f"One grid step in {where} makes the best value worse by more than a tenth; a better design may lie "
                "between the grid points."
            )
        case "neighbourhood_unknown":
            return (
                "Not every value next to the best design along "
                f"{listed(map(phrases.symbol, known['dimensions']))} is known."
            )
        case "incomplete":
            if "reduce" in known:
                return f"Not everything is computed: the {known['reduce']} is taken over the points so far."
            return (
                f"Only {share(known['complete'])} of the designs are computed, so nothing is recommended yet."
            )
        case "failed":
            return "Where a point failed, for example with an unbounded response, the largest value is not known."
        case "missing":
            reasons = (("waiting", "not computed yet"), ("failed", "failed"))
            why = ", ".join(f"{known[name]:,} {reason}" for name, reason in reasons if known[name])
            count = known["waiting"] + known["failed"]
            return f"{count:,} of {known['of']:,} frequencies {'has' if count == 1 else 'have'} no value ({why})."
        case "other_excitation":
            return (
                "Here a force excites the structures with the tuned mass damper and without a damper. X is relative "
                "to the static displacement. In the study the base is shaken."
            )
        case "promising":
            return f"{counted(known['cells'], 'cell')} of the grid {_better(known)}."
        case "known":
            return (
                f"The optimum is known to {known['tolerance']:g} in every parameter, and no other cell of the grid "
                f"{_better(known)}. A dip within a cell cannot be excluded if no corner of the cell shows it."
            )
        case "place_not_known":
            return (
                f"No other cell of the grid {_better(known)}; the place of the optimum is known only to steps of "
                f"{_steps(known, phrases)}."
            )
        case "place_within_errors":
            return (
                f"No cell of the grid {_better(known)}, so the value of the optimum is known. The errors hide the "
                "differences between neighbours, so the place of the optimum is known only to "
                f"steps of {_steps(known, phrases)}. A smaller `steady.tolerance` locates the optimum better."
            )
        case "budget":
            return f"The optimum is not known yet: {over_budget(known)}."
        case "follow_ups":
            return f"{counted(known['points'], 'point')} in {counted(known['studies'], 'follow-up')} next."
        case "spent":
            return _spent(known)
        case "cost":
            return _cost(known)
        case "particle_friction":
            return f"Friction of the particle {': '.join(friction_allowed(note))}."
        case "boundary":
            along = known["along"]
            low, high = (phrases.value(along, known[end], ".10g") for end in ("low", "high"))
            what = f"{known['below']} to {known['above']}"
            return f"The response along {phrases.label(along)} changes from {what} between {low} and {high}."
    raise KeyError(note.kind)


def share(complete: float) -> str:
    """Write the computed share of a study in per cent, rounded down, so that only a complete study has 100 %."""
    return f"{floor(1000 * complete) / 10:g} %"


def friction_allowed(note: Note) -> tuple[str, str]:
    """Return two parts of a sentence: a range of μ_i, and how much the value rises in this range."""
    up_to, fails = note.values["up_to"], note.values["fails"]
    if not up_to:
        return f"from μ_i = {fails:g} on", "the value may rise by more than a tenth"
    if fails is None:
        return f"up to μ_i = {up_to:g}, the highest examined", "the value rises by at most a tenth"
    return f"up to μ_i = {up_to:g}", f"the value rises by at most a tenth, at {fails:g} by more"


def over_budget(known: Values) -> str:
    """Say that the next step of a search needs more points than its budget has left."""
    budget, left = known["points"], known["left"]
    than = (
        f"the budget of {counted(budget, 'point')}"
        if left == budget
        else f"the {left:,} left of the budget of {counted(budget, 'point')}"
    )
    return f"the next step takes {counted(known['next_points'], 'point')}, more than {than}"


def advised_axis(known: Values, phrases: Phrases) -> str:
    """Return the frequency axis that resolves a hidden peak, written as in the definition of a study."""
    name = "excitation_frequency_hz" if phrases.unit(FREQUENCY) else FREQUENCY
    start, stop = (phrases.number(FREQUENCY, known[end], ".10g") for end in ("start", "stop"))
    return f"`{name}: {{start: {start}, stop: {stop}, num: {known['num']}}}`"


def _hidden_peak(known: Values, phrases: Phrases) -> str:
    higher = "far higher" if known["apart"] > FAR * known["bandwidth"] else "more than a tenth higher"
    whose = _whose(known)
    return (
        f"{whose[:1].upper()}{whose[1:]} may be {higher} between two frequencies, which are up to "
        f"{phrases.value(FREQUENCY, known['apart'], '.3g')} apart. Compute {advised_axis(known, phrases)}."
    )


def _whose(known: Values) -> str:
    """Name the values that a hidden peak may exceed: values in a map, values of ranked designs, or the study's peak."""
    if "places" in known:
        values = "value" if known["places"] == 1 else "values"
        return f"the largest {values} of {known['places']:,} of {known['of']:,} points of the map"
    if "listed" not in known:
        return "the study's peak"
    count, whose = known["listed"], []
    if count == 1 and known["best"]:
        whose.append("the largest value of the best design")
    elif count:
        among = ", the best design among them," if known["best"] else ""
        values = "value" if count == 1 else "values"
        whose.append(f"the largest {values} of {count} of the first {known['of']} designs{among}")
    if known["with_impacts"]:
        value = "that" if whose else "the largest value"
        whose.append(f"{value} of the best design with impacts")
    return " and ".join(whose)


def _better(known: Values) -> str:
    return f"can contain a design better by more than {100 * known['better_by']:.2g} %"


def _steps(known: Values, phrases: Phrases) -> str:
    steps = known["steps"].items()
    return ", ".join(f"{phrases.value(name, step, '.3g')} in {phrases.label(name)}" for name, step in steps)


def _spent(known: Values) -> str:
    parts = [f"{known['points']:,} points"]
    if "cycles" in known:
        parts.append(f"{known['cycles']:,} cycles")
    if "seconds" in known:
        parts.append(f"{known['seconds']:.3g} s of run time")
    return f"Computed so far: {', '.join(parts)}."


def _cost(known: Values) -> str:
    """State the cost of a search, and the cost of a uniform grid with equally small steps."""
    points, fine = known["points"], known["fine_points"]
    if points >= fine:
        return f"{counted(points, 'point')} in all; a grid with these steps has {counted(fine, 'point')}."
    return (
        f"{counted(points, 'point')} in all, {fine - points:,} fewer than the {fine:,} of a grid with these steps "
        f"({fine / points:.3g} times fewer)."
    )
