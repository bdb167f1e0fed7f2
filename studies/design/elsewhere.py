"""What other starts and other amplitudes do to the recommended damper, in words."""

from collections.abc import Iterator
from math import isfinite

from damperlab.studies.design.backbone import peaks_of
from damperlab.studies.design.found import Found
from damperlab.studies.design.spelling import frequency, length, level, plural, response
from damperlab.studies.design.starts import FROM, Reached, Several, Starts
from damperlab.studies.faults import counted
from damperlab.studies.specification.specification import Specification


def words_of_starts(found: Found) -> Iterator[str]:
    """Say what other starts than rest lead to, and where they lead to several responses."""
    asked, starts = found.asked, found.starts
    if starts is None:
        return
    at = "1 frequency ratio" if starts.frequencies == 1 else f"each of {starts.frequencies} frequency ratios"
    looked = f"Started in {counted(starts.count, 'way')} at {at}"
    if starts.beyond is None:
        yield (
            f"{looked}, the damper as drawn reaches a displacement of the structure up to {length(asked, starts.worst)}, "
            f"near {frequency(asked, starts.frequency_ratio)}."
        )
    elif starts.beyond == 0:
        yield f"{looked}, the damper as drawn does not exceed what is stated."
    else:
        yield (
            f"{looked}, the damper as drawn reaches up to {response(asked, starts.worst)}, near "
            f"{frequency(asked, starts.frequency_ratio)}: at {starts.beyond} of these ratios a disturbance can take it "
            f"beyond what is stated, which holds{FROM[asked.judge]}."
        )
    worst = starts.worst_of_several
    if worst is not None:
        yield _several(asked, starts, worst)


def _several(asked: Specification, starts: Starts, worst: Several) -> str:
    """Say which responses there are where there are several, at the frequency at which one of them is highest."""
    first, *others = worst.responses
    parts = [
        f"{_led(starts, first.share)} of the {counted(starts.count, 'start')} lead to {_reached(asked, first)}"
    ]
    parts += [f"{_led(starts, each.share)} to {_reached(asked, each)}" for each in others]
    if worst.share_left:
        parts.append(f"{_led(starts, worst.share_left)} to others, or failed")
    at = f"near {frequency(asked, worst.frequency_ratio)}"
    which = at if starts.several == 1 else f"where one of them is highest, {at},"
    return f"At {starts.several} of these ratios it has more than one response: {which} {', '.join(parts)}."


def _led(starts: Starts, share: float) -> int:
    return round(share * starts.count)


def _reached(asked: Specification, one: Reached) -> str:
    about = [one.response_class.replace("_", " ")] if one.response_class else []
    about += ["the one from rest"] if one.from_rest else []
    judged = ""
    if one.value is not None and not asked.measure.of_displacement:
        judged = f" and {response(asked, one.value)}{asked.measure.kind}"
    return length(asked, one.displacement) + judged + (f" ({', '.join(about)})" if about else "")


def words_of_amplitudes(found: Found) -> Iterator[str]:
    """Say what the damper does under amplitudes from half the least to twice the largest."""
    asked, shown = found.asked, found.shown
    if len(shown) < 2 or not asked.in_units:
        return
    worst = [(each, curve.judged) for each, curve, _ in peaks_of(found)]
    (least, low), (largest, high) = worst[0], worst[-1]
    if not (isfinite(low) and isfinite(high)):
        return
    what = f"the {asked.measure.judged} is" if asked.measure.mean else "the damper as drawn reaches"
    grown = largest.reference_m / least.reference_m
    more = f", {high / low:.3g} times as much under {grown:.3g} times the amplitude" if low > 0.0 else ""
    yield (
        f"Under {plural(least.excitation.motion)} from {level(asked, least)} to {level(asked, largest)} {what} "
        f"{response(asked, low)} to {response(asked, high)}{more}."
    )
