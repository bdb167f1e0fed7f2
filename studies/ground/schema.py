"""JSON schema of a ground-motion suite, for OpenAPI documents and editors."""

from typing import Any

from damperlab.studies.axes import axis_schema
from damperlab.studies.ground.generated import LISTED_SCHEMAS, WRITTEN
from damperlab.studies.ground.quantities import QUANTITIES
from damperlab.studies.ground.suite import AXES, NUMBERS
from damperlab.studies.ground.suite_reading import MOST_NAME, MOST_RECORDS
from damperlab.studies.ground.variables import VARIABLES
from damperlab.studies.questions import MOST_STARTS


def suite_json_schema() -> dict[str, Any]:
    """Return the self-contained JSON schema of a suite."""
    record = {
        "anyOf": [
            {"type": "string", "description": "the id of a record, or an earthquake's name"},
            {
                "type": "object",
                "description": f"{WRITTEN}, or a record as written in a stored study",
                "properties": LISTED_SCHEMAS,
            },
        ]
    }
    numbers = {name: QUANTITIES[name] for name in NUMBERS}
    return {
        "type": "object",
        "description": "A grid of responses to ground motions, in physical units; a study that names `records` is one.",
        "required": ["records"],
        "additionalProperties": False,
        "properties": {
            "name": {"type": "string", "maxLength": MOST_NAME, "default": ""},
            "records": {"type": "array", "items": record, "minItems": 1, "maxItems": MOST_RECORDS},
            "axes": {
                "type": "object",
                "additionalProperties": False,
                "properties": {name: axis_schema(*QUANTITIES[name]) for name in AXES},
            },
            **{name: quantity.schema(default) for name, (quantity, default) in numbers.items()},
            "starts": {
                "type": "integer",
                "minimum": 0,
                "maximum": MOST_STARTS,
                "default": 0,
                "description": "perturbed starts of each point, whose spread is stored",
            },
            "seed": {"type": "integer", "minimum": 0, "default": 0, "description": "seed of the starts"},
            "contact": {
                "type": "object",
                "description": "{model: instant}, or {model: dwell, contact_time: …} in units of 1/ω_n",
            },
            "metrics": {
                "type": "array",
                "items": {"type": "string", "enum": list(VARIABLES)},
                "minItems": 1,
                "uniqueItems": True,
            },
        },
    }
