"""The JSON schema of a specification, for OpenAPI documents, editors and forms."""

from typing import Any

from damperlab.studies.definition import MAX_NAME
from damperlab.studies.ground.generated import LISTED_SCHEMAS
from damperlab.studies.physical import (
    DAMPING,
    EXCITATION_FREQUENCY,
    MASS,
    NATURAL_FREQUENCY,
)
from damperlab.studies.quantity import DAMPING_RATIO, FREQUENCY_RATIO, RESTITUTION, Quantity
from damperlab.studies.specification.damper import CONTACT_TIME, MOST_VALUES, QUANTITIES
from damperlab.studies.specification.limit_fields import (
    IN_RATIOS,
    LIMIT_QUANTITIES,
    RATIO_QUANTITIES,
)
from damperlab.studies.specification.measure import (
    DAMPER_LIMITS,
    LIMITS,
    MEASURES,
    MIXED_MEASURES,
    RECORD_MEASURES,
)
from damperlab.studies.specification.reading import BUDGET_MINUTES, CONFIDENCE
from damperlab.studies.specification.record_fields import MOST_CASES, OF_RECORDS, SCALE, TAIL
from damperlab.studies.specification.scene import (
    BASE,
    EXCITATION_KEYS,
    MOST_EXCITATIONS,
    MOST_LETTERS,
    STIFFNESS,
    STRUCTURE_KEYS,
)
from damperlab.studies.specification.specification import JUDGES, OF_STRUCTURE
from damperlab.studies.specification.tolerance_fields import ANYTHING

Schema = dict[str, Any]

OF_SCENE: dict[str, Quantity] = {
    each.name: each
    for each in (
        MASS, NATURAL_FREQUENCY, STIFFNESS, DAMPING_RATIO, DAMPING, *BASE.values(), FREQUENCY_RATIO,
    )
} | {"frequency_hz": EXCITATION_FREQUENCY}  # fmt: skip
"""For each key of `structure` and `excitation` in a specification, the physical quantity that the key gives."""
LIMIT_WORDS = {
    each.name: each.words + ("" if each.under_record else ", over bands") for each in LIMITS.values()
} | {
    name: each.words + (", twice the clearance" if each.factor == 2.0 else "") + ", as built"
    for name, each in DAMPER_LIMITS.items()
}


WORDS = (
    "Motion of the base, or a force, at every frequency of the band and with every amplitude of the range."
)
MEASURE_WORDS = (
    f"The measure to minimise. Over a band one of {', '.join(MEASURES)}; under records and sweeps one of "
    f"{', '.join(RECORD_MEASURES)}; under both one of {', '.join(MIXED_MEASURES)}. The first of each is the default."
)
NAME: Schema = {"type": "string", "minLength": 1, "maxLength": MOST_LETTERS}


def specification_schema() -> Schema:
    """Return the JSON schema of a specification, without references."""
    excitation = {name: _span(OF_SCENE[name]) for name in EXCITATION_KEYS}
    measures = list(dict.fromkeys((*MEASURES, *RECORD_MEASURES)))
    return {
        "type": "object",
        "description": "Requirements, ranges of the damper and tolerances; in units, or in ratios.",
        "required": ["structure", "excitation"],
        "additionalProperties": False,
        "properties": {
            "name": {"type": "string", "maxLength": MAX_NAME - 20, "default": ""},
            "structure": _object(
                {name: OF_SCENE[name].schema() for name in STRUCTURE_KEYS}, "The structure to protect from vibration."
            ),
            "excitation": {
                "anyOf": [
                    _object(excitation, WORDS),
                    _records(),
                    {
                        "type": "array",
                        "description": "Several excitations, applied one at a time; the worst is judged.",
                        "minItems": 1,
                        "maxItems": MOST_EXCITATIONS,
                        "items": {"anyOf": [_object({"name": NAME} | excitation, WORDS), _records({"name": NAME})]},
                    },
                ]
            },
            "choose": _object(
                {name: _choice(quantity) for name, quantity in QUANTITIES.items()},
                "Allowed values of the damper: a range, or a list.",
            ),
            **{name: quantity.schema() for name, quantity in QUANTITIES.items()},
            CONTACT_TIME.name: CONTACT_TIME.schema(),
            "tolerances": _object(
                {name: _tolerance() for name in (*QUANTITIES, *OF_STRUCTURE)},
                "Tolerances to either side: a number in the unit, or a share written as 10%.",
            ),
            "limits": _object(
                {name: _limit(name) for name in LIMIT_QUANTITIES | RATIO_QUANTITIES}, "Largest allowed values."
            ),
            "measure": {"type": "string", "enum": measures, "description": MEASURE_WORDS},
            "judge": {
                "type": "string",
                "enum": list(JUDGES),
                "default": "rest",
                "description": "Which response is judged if there are several: "
                + "; ".join(f"`{name}`, {words}" for name, words in JUDGES.items()),
            },
            "confidence": CONFIDENCE.schema(0.9),
            "budget_minutes": BUDGET_MINUTES.schema(8.0),
            "budget_points": _count("largest number of points, in place of core minutes", 100),
            "builds": _count("number of builds drawn at random within the tolerances", 0, 10_000) | {"default": 60},
        },
    }  # fmt: skip


def _records(more: Schema | None = None) -> Schema:
    entry = {
        "anyOf": [{"type": "string"}, {"type": "object", "properties": LISTED_SCHEMAS}],
    }
    scales = {"type": "array", "minItems": 1, "maxItems": MOST_CASES, "items": SCALE.schema()}
    return {
        "type": "object",
        "description": "Ground-motion records, or a generated one, each at every scale; the worst is judged.",
        "oneOf": [{"required": [key]} for key in OF_RECORDS],
        "additionalProperties": False,
        "properties": {
            "records": {
                "description": "Ids of records, names of earthquakes, or records to generate, for example "
                "`{sweep: {…}}`.",
                "anyOf": [entry, {"type": "array", "minItems": 1, "maxItems": MOST_CASES, "items": entry}],
            },
            **LISTED_SCHEMAS,
            "scales": {"description": SCALE.meaning, "default": 1, "anyOf": [SCALE.schema(), scales]},
            "tail_s": TAIL.schema(0.0),
        }
        | (more or {}),
    }


def _count(meaning: str, lowest: int, highest: int = 10_000_000) -> Schema:
    return {"type": "integer", "description": meaning, "minimum": lowest, "maximum": highest}


def _object(properties: Schema, description: str) -> Schema:
    return {
        "type": "object",
        "description": description,
        "additionalProperties": False,
        "properties": properties,
    }


def _range(quantity: Quantity) -> Schema:
    ends = {"start": quantity.schema(), "stop": quantity.schema()}
    return {
        "type": "object",
        "required": list(ends),
        "additionalProperties": False,
        "properties": ends,
    }


def _span(quantity: Quantity) -> Schema:
    return {"description": quantity.meaning, "anyOf": [quantity.schema(), _range(quantity)]}


def _choice(quantity: Quantity) -> Schema:
    properties: Schema = {"name": {"type": "string"}, quantity.name: quantity.schema()}
    if quantity is RESTITUTION:
        properties[CONTACT_TIME.name] = CONTACT_TIME.schema()
    named = {
        "type": "object",
        "description": "a value with a name, for example the name of a material",
        "required": [quantity.name],
        "additionalProperties": False,
        "properties": properties,
    }
    values = {
        "type": "array",
        "minItems": 2,
        "maxItems": MOST_VALUES,
        "items": {"anyOf": [quantity.schema(), named]},
    }
    return {"description": quantity.meaning, "anyOf": [_range(quantity), values]}


def _tolerance() -> Schema:
    return {"anyOf": [ANYTHING.schema(), {"type": "string", "pattern": "^ *[0-9.]+ *%$"}]}


def _limit(name: str) -> Schema:
    if name in IN_RATIOS:
        words = f"{LIMIT_WORDS[IN_RATIOS[name]]}, as a ratio if the specification is in ratios"
        return RATIO_QUANTITIES[name].schema() | {"description": words}
    return LIMIT_QUANTITIES[name].schema() | {"description": LIMIT_WORDS[name]}
