"""The module `words.js`, which gives the page the names, units and limits that the Python code defines."""

import json
from typing import Any

from damperlab.service.questions.every import EVERY
from damperlab.studies.amplitudes import AMPLITUDE
from damperlab.studies.amplitudes import DIMENSIONS as AMPLITUDE_DIMENSIONS
from damperlab.studies.answers.phrases import PRINTED
from damperlab.studies.choices import Steady
from damperlab.studies.design.spelling import CALLED
from damperlab.studies.fit.question import BESIDE_AXES, FREE, NAMED
from damperlab.studies.ground.paper import BASE_AMPLITUDES_M
from damperlab.studies.ground.quantities import QUANTITIES
from damperlab.studies.ground.random_vibration import DURATION, FREQUENCY, LEVELS
from damperlab.studies.ground.shock import NUMBERS, SHAPES
from damperlab.studies.ground.sweep import AMPLITUDES as AMPLITUDES_OF_SWEEP
from damperlab.studies.ground.sweep import ENDS, PACES
from damperlab.studies.ground.variables import DAMPER
from damperlab.studies.ground.variables import DIMENSIONS as SUITE_DIMENSIONS
from damperlab.studies.ground.variables import SYMBOLS as SUITE_SYMBOLS
from damperlab.studies.ground.variables import VARIABLES as SUITE_VARIABLES
from damperlab.studies.kinds import AMPLITUDES as AMPLITUDES_KIND
from damperlab.studies.kinds import HARMONIC, SUITE
from damperlab.studies.physical import DERIVATIONS, EXCITATION_FREQUENCY
from damperlab.studies.physical import QUANTITIES as PHYSICAL_QUANTITIES
from damperlab.studies.remarks import TAG, TAG_WORDS
from damperlab.studies.rounding import ROUNDING, ROUNDING_WORD
from damperlab.studies.specification.damper import CONTACT_TIME
from damperlab.studies.specification.damper import QUANTITIES as SPECIFIED
from damperlab.studies.specification.excitation import MOTIONS
from damperlab.studies.specification.limit_fields import LIMIT_KEYS, LIMIT_QUANTITIES
from damperlab.studies.specification.measure import LIMITS, MEASURES, RECORD_MEASURES
from damperlab.studies.specification.record_fields import TAIL
from damperlab.studies.specification.scene import EXCITATION_KEYS, MOST_EXCITATIONS, STRUCTURE_KEYS
from damperlab.studies.specification.schema import LIMIT_WORDS, OF_SCENE, specification_schema
from damperlab.studies.specification.specification import CHOSEN, OF_DAMPER, OF_STRUCTURE, RATIO_OF
from damperlab.studies.spelling import unit_of
from damperlab.studies.unit_names import (
    ACCELERATIONS,
    AMPLITUDES,
    COORDINATE_SOURCES,
    ENERGY,
    OVER,
    RESULT_NAMES,
    SPEED,
)
from damperlab.studies.variables import DIMENSION_NAMES, DIMENSIONS, MADE_BY, SYMBOLS
from damperlab.studies.vocabulary import (
    ACCELERATION_UNITS,
    CONTACT_MODELS,
    CRITERION_NAMES,
    DESIGN_POINT,
    ENDED,
    EXCITATIONS,
    EXPORT_FORMATS,
    OBJECTIVES_IN_UNITS,
    OF_PARTICLE,
    RESPECTS,
    START_KINDS,
    STATES,
)

_IN_SI = AMPLITUDES | ACCELERATIONS | {"impact_speed_max": SPEED, "dissipation_per_cycle": ENERGY}
"""For each result that can be given in SI units, its name in SI units."""

_RESULT_UNITS = {SPEED: "m/s", ENERGY: "J"} | dict.fromkeys(ACCELERATIONS.values(), "m/s²")
"""SI unit of each result that is not a length, by the name of the result in SI units."""

_KINDS = {"harmonic": HARMONIC, "suite": SUITE, "amplitudes": AMPLITUDES_KIND}
"""Kinds of study, by their names on the page."""

MODULE = "words.js"
"""Name of the module; `words.d.ts` has its types."""


_SOURCES = {each.name for each in PHYSICAL_QUANTITIES}
_SELDOM = ("damping_n_s_per_m", *MADE_BY.values())
"""Fields that the form of a fit shows only if the document contains them."""


def words_module() -> bytes:
    """Return the text of the module, which defines one constant. The text depends only on the Python code."""
    text = json.dumps(_words(), ensure_ascii=False, indent=1)
    return f"/** Made by the service. */\nexport const WORDS = {text};\n".encode()


def _words() -> dict[str, Any]:
    prototype = _prototype()
    return {
        "questions": [
            {name: getattr(question, name) for name in ("summary", "route", "command", "method")}
            | {"kinds": [name for name, kind in _KINDS.items() if kind in question.kinds]}
            for question in EVERY
        ],
        "symbols": SYMBOLS,
        "dimensions": DIMENSIONS,
        "before": MADE_BY,
        "names": {name: _capital(words) for name, words in DIMENSION_NAMES.items()} | _names_in_si(),
        "units": {AMPLITUDE: "mm"}
        | {name: _shown_unit(unit) for name, (unit, _) in SUITE_DIMENSIONS.items()},
        "of_particle": OF_PARTICLE,
        "axes": (*HARMONIC.axes, *MADE_BY),
        "tag_pattern": TAG.pattern,
        "tag_words": TAG_WORDS,
        "suite_axes": SUITE.axes,
        "amplitude_axes": AMPLITUDES_KIND.axes,
        "damper": DAMPER,
        "amplitude_damper": AMPLITUDES_KIND.designs,
        "results_in_units": {
            name: (source, RESULT_NAMES[name], _RESULT_UNITS.get(name, "m"))
            for source, name in _IN_SI.items()
        },
        "design_point": DESIGN_POINT,
        "prototype": prototype,
        "structure": {
            name: prototype[name] for name in ("mass_kg", "natural_frequency_hz", "base_amplitude_m")
        },
        "stands_for": {ratio: made.source for ratio, made in DERIVATIONS.items()},
        "in_units": _in_units(),
        "objectives_in_units": OBJECTIVES_IN_UNITS,
        "respects": {name: source for name, (source, _) in RESPECTS.items()},
        "judged": _judged(),
        "over": OVER,
        "rounding": {"share": ROUNDING, "word": ROUNDING_WORD},
        "names_in_si": _names_in_si_of_ratios(),
        "states": STATES,
        "ended": ENDED,
        "excitations": EXCITATIONS,
        "contact_models": CONTACT_MODELS,
        "start_kinds": START_KINDS,
        "criteria": CRITERION_NAMES,
        "export_formats": EXPORT_FORMATS,
        "acceleration_units": list(ACCELERATION_UNITS),
        "steady": Steady().model_dump(),
        "specification": _specification(),
        "fitted": [_fitted(name, quantity.meaning) for name, quantity in NAMED.items()],
    }


def _fitted(name: str, meaning: str) -> dict[str, Any]:
    """Describe a quantity of a prototype; `path` is its place in the known values of a fit."""
    place = "physical." if name in _SOURCES else "" if name in BESIDE_AXES else "axes."
    return _specified(name, meaning) | {
        "path": f"{place}{name}",
        "free": name in FREE,
        "usual": name in (*_SOURCES, "damping_ratio", "restitution") and name not in _SELDOM,
    }


def _specification() -> dict[str, Any]:
    """Describe the fields of a specification, for the page's form for a new design."""
    chosen = [_specified(name, SPECIFIED[name].meaning) | {"ratio": RATIO_OF[name]} for name in CHOSEN]
    for each in chosen:
        each["called"] = each["label"].partition(",")[0]
    return {
        "structure": [
            _specified(name, OF_SCENE[name].meaning)
            | {"usual": name in OF_STRUCTURE, "loose": name in OF_STRUCTURE}
            for name in STRUCTURE_KEYS
        ],
        "excitation": {
            "motions": [_specified(name, OF_SCENE[name].meaning) for name in MOTIONS],
            "frequency": [
                _specified(name, OF_SCENE[name].meaning) for name in EXCITATION_KEYS if name not in MOTIONS
            ],
            "sweep": {
                name: [_specified(key, quantity.meaning) for key, quantity in fields.items()]
                for name, fields in (("ends", ENDS), ("paces", PACES), ("amplitudes", AMPLITUDES_OF_SWEEP))
            },
            "random_vibration": {
                "frequency": _specified(FREQUENCY.name, "frequencies of the table, ascending [Hz]"),
                "levels": [_specified(key, quantity.meaning) for key, quantity in LEVELS.items()],
                "numbers": [
                    _specified(DURATION.name, DURATION.meaning),
                    _specified("seed", "seed of the first draw"),
                    _specified("seeds", "number of draws"),
                ],
            },
            "shock": {
                "shapes": SHAPES,
                "numbers": [_specified(key, quantity.meaning) for key, (quantity, _) in NUMBERS.items()],
            },
            "most": MOST_EXCITATIONS,
            "tail": _specified("tail_s", TAIL.meaning),
        },
        "damper": chosen,
        "cavity": [
            {"name": name, "label": CALLED[name], "called": CALLED[name]}
            | {"unit": unit_of(name), "scale": 1.0, "ratio": ""}
            for name in MADE_BY.values()
        ],
        "ratios": {
            name: _specified(name, quantity.meaning)
            for name, quantity in SPECIFIED.items()
            if name not in OF_DAMPER
        },
        "contact_time": _specified(CONTACT_TIME.name, CONTACT_TIME.meaning)
        | {"unit": "ms", "scale": 1e3, "usual_value": 0},
        "limits": [
            _specified(name, f"{LIMIT_WORDS[name]} {_unit_of(LIMIT_QUANTITIES[name].meaning)}")
            | {"over_bands": name in LIMITS and not LIMITS[name].under_record}
            for name in LIMIT_KEYS
        ],
        "numbers": [
            _specified(name, about["description"]) | {"usual_value": about.get("default")}
            for name, about in specification_schema()["properties"].items()
            if about.get("type") in ("number", "integer")
            and name not in (*CHOSEN, *RATIO_OF.values(), CONTACT_TIME.name)
        ],
        "tables": {
            "measures": {name: each.judged for name, each in MEASURES.items()},
            "at_a_frequency": {name: each.words for name, each in MEASURES.items() if each.mean},
            "measures_under_records": {name: each.words for name, each in RECORD_MEASURES.items()},
            "accelerations": [
                name for name, each in (MEASURES | RECORD_MEASURES).items() if each.unit == "m/s²"
            ],
        },
    }


def _specified(name: str, meaning: str) -> dict[str, Any]:
    """Describe a field of a specification. `scale` is the factor from the unit of the document to the shown unit."""
    unit = _unit_of(meaning).strip("[]")
    label = meaning.removesuffix(f" [{unit}]")
    return {
        "name": name,
        "label": label,
        "unit": "mm" if unit == "m" else unit,
        "scale": 1e3 if unit == "m" else 1.0,
    }


def _unit_of(meaning: str) -> str:
    return meaning[meaning.rindex("[") :] if meaning.endswith("]") else ""


def _prototype() -> dict[str, float]:
    """Return the paper's prototype in SI units, excited at resonance.

    The paper implies a base amplitude for each cavity; the value for the smallest cavity is used.
    """
    defaults = {
        name: default
        for name, (_, default) in QUANTITIES.items()
        if name in SUITE_SYMBOLS or name == "mass_kg"
    }
    return {
        **defaults,
        "base_amplitude_m": BASE_AMPLITUDES_M[0],
        EXCITATION_FREQUENCY.name: defaults["natural_frequency_hz"],
    }


def _names_in_si() -> dict[str, str]:
    """Return readable names of the base amplitude and of the dimensions that only suites have."""
    amplitude = AMPLITUDE_DIMENSIONS[AMPLITUDE][1].removesuffix(" Z")
    return {AMPLITUDE: _capital(amplitude)} | {
        name: _capital(words.removesuffix(f" {SUITE_SYMBOLS.get(name, '')}"))
        for name, (_, words) in SUITE_DIMENSIONS.items()
        if name not in SYMBOLS
    }


def _shown_unit(unit: str) -> str:
    """Return the unit that the page shows; lengths are shown in mm."""
    return {"m": "mm", "1": ""}.get(unit, unit)


def _in_units() -> dict[str, tuple[str, str, str, float]]:
    """For each ratio, return symbol, label, unit and scale of the quantity that the page shows in units instead."""
    shown = {}
    for name, (symbol, label, unit, scale) in PRINTED.items():
        if name in SYMBOLS:
            label = _capital(label)
        elif name != HARMONIC.metric and name in AMPLITUDES:
            symbol, label = "", RESULT_NAMES[AMPLITUDES[name]]
        shown[name] = (symbol, label, unit, scale)
    return shown


def _names_in_si_of_ratios() -> dict[str, str]:
    """Return, for each ratio, the name under which the service gives the quantity in SI units."""
    coordinates = {ratio: name for name, ratio in COORDINATE_SOURCES.items()}
    return coordinates | _IN_SI


def _judged() -> list[str]:
    """Return the names of results that a good damper makes small. Errors, energies and counts are left out."""
    lengths = [
        name for names in AMPLITUDES.items() for name in names if not name.startswith("amplitude_error")
    ]
    of_suites = [name for name in SUITE_VARIABLES if name.startswith(("peak_", "rms_"))]
    return [*lengths, *of_suites]


def _capital(words: str) -> str:
    return words[:1].upper() + words[1:]
