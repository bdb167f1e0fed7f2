"""Units as people write them: `CM/SEC**2`, `m·s⁻²`, `(G'S)`, `msec`."""

import re

from damperlab.studies.vocabulary import ACCELERATION_UNITS

TIMES = {"s": 1.0, "ms": 1e-3, "µs": 1e-6}
LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "µm": 1e-6, "in": 0.0254, "ft": 0.3048}
ACCELERATIONS = {
    **ACCELERATION_UNITS,
    "mm/s2": 1e-3,
    "in/s2": LENGTHS["in"],
    "ft/s2": LENGTHS["ft"],
    "%g": 0.01 * ACCELERATION_UNITS["g"],
    "mg": 1e-3 * ACCELERATION_UNITS["g"],
}
"""Value of each unit of acceleration in m/s², by the usual spelling."""

BRACKETS = re.compile(r"[(\[{]((?:[^()\[\]{}]|\([^()]*\))*)[)\]}]")
OF_PEAK = re.compile(r"\b(?:peak|max\w*|largest|pga)\b", re.IGNORECASE)
"""Words in a line with the peak of a record. The unit of the peak may differ from the unit of the samples."""
_FACTOR = re.compile(
    r"(?:[/×·]|(?<!\*)\*)\s*\d|(?:\b|_)x\s*\d|\btimes\b\s*\d|\d\s*(?:\^|\*\*)|\be[-+]?\d"
    r"|^\s*[\d.]+\s+[a-z]|(?:multipl|normali[sz])\w+ (?:by|with)|\b(?:hundred|thousand|million)ths?\b",
    re.IGNORECASE,
)
_NUMBER_BEFORE = re.compile(r"(?:^|[\s_])[\d.]+(?:e[-+]?\d+)?[\s_]+([^\s_]+)", re.IGNORECASE)
"""A number and the word after it. If this word is the unit of a heading, the number is a factor."""
_TIME = re.compile(r"(?:\w+ )?(?:time|times|t|sec|seconds?|zeit|temps|tiempo|tempo)", re.IGNORECASE)
_NO_SUFFIX = ("h", "v", "in")
"""Unit symbols that usually denote a direction if they end a heading, as in `acc_h`."""
_LONGEST = 40
"""Largest length of an examined text; real units are shorter."""
_KINDS = {
    "a time": (*TIMES, "ns", "min", "minutes", "h", "hours", "samples"),
    "an acceleration": tuple(ACCELERATIONS),
    "a velocity": (*(f"{length}/s" for length in LENGTHS), "km/s", "km/h", "mph"),
    "a displacement": (*LENGTHS, "km"),
    "a frequency": ("hz", "khz", "rad/s", "rpm"),
    "a reading": ("count", "counts", "v", "mv", "volt", "volts"),
}
_SPELLINGS = tuple(
    (re.compile(pattern), usual)
    for pattern, usual in (
        (r"μ|micro[\s-]?", "µ"),
        (r"\bper\s?cent\b|\bpct\b", "%"),
        (r"\s*\bper\b\s*", "/"),
        (r"\s*\b(?:squared|sq)\b", "2"),
        (r"milli[\s-]?", "m"),
        (r"centi", "c"),
        (r"met(?:er|re)s?", "m"),
        (r"sec(?:ond)?s?", "s"),
        (r"inch(?:es)?|[″\"]", "in"),
        (r"feet|foot", "ft"),
        (r"['’`´]s$|(?<=^g)s$", ""),
        (r"^gals?$", "cm/s2"),
        (r"^u(?=[ms]$)", "µ"),
        (r"(?<=%)\s*of\b|[\s^*·.()\[\]{}_]", ""),
        (r"(?<=m)p(?=s)", "/"),
        (r"(?<=[mtn])(?:/s/s|/?ss|s-2|s2)$", "/s2"),
        (r"(?<=[mtn])s-1$", "/s"),
    )
)


def usual(written: str) -> str:
    """Return the usual spelling of a unit, in lower case. An unknown unit is only simplified."""
    unit = written.lower().translate(str.maketrans("⁻−²¹", "--21")).strip(" \t.:;,'`()[]{}")
    for pattern, plain in _SPELLINGS:
        unit = pattern.sub(plain, unit)
    return unit


def kind_of(written: str) -> str:
    """Return the kind of quantity of a unit, for example `a velocity`; empty if the unit is unknown."""
    unit = usual(written) if len(written) <= _LONGEST else ""
    if unit.endswith("2/hz"):
        return "a spectral density"
    return next((kind for kind, units in _KINDS.items() if unit in units), "")


def is_time(words: str) -> bool:
    """Return whether the words of a heading, without its unit, name a time in one of several languages."""
    return bool(_TIME.fullmatch(words))


def taken_apart(cell: str) -> tuple[str, list[str]]:
    """Split a heading into its words and its unit, as in `acc (g)`, `acc in g`, `acc / g`, `acc_g`."""
    stated, bare = BRACKETS.findall(cell), BRACKETS.sub(" ", cell)
    words = re.sub(r"[\s_./,]+", " ", bare).strip()
    number = None if stated else _NUMBER_BEFORE.search(cell)
    if _FACTOR.search(cell) or (number and kind_of(number[1])):
        return words, [cell]
    if stated:
        return words, [each for each in stated if kind_of(each)] or stated[-1:]
    if kind_of(cell):
        return "", [cell]
    for parting in re.finditer(r"\s+in\s+|\s*/\s*|[\s_,]+", cell):
        before, unit = cell[: parting.start()].replace("_", " "), cell[parting.end() :]
        apart = parting[0].strip(" _,")
        known = kind_of(unit) and (apart or unit.lower() not in _NO_SUFFIX)
        if known or (apart == "in" and " " not in unit):
            return before, [unit]
    return words, []
