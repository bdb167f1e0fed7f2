"""JSON schemas of the bodies that are read by hand, for the OpenAPI document."""

from typing import Any

from damperlab.service.simulation import HISTORY_CYCLES, HISTORY_PERIODS, SAMPLES, SEED_LIMIT, STARTS_LIMIT
from damperlab.studies.ground.paper import CASES
from damperlab.studies.ground.question import MOST_STARTS, QUANTITIES
from damperlab.studies.quantity import RATIOS
from damperlab.studies.tmd.tunings import CRITERIA
from damperlab.studies.variables import DIMENSIONS
from damperlab.studies.vocabulary import DEFAULTS


def _contact(*models: str) -> dict[str, Any]:
    return {"anyOf": [{"$ref": f"#/components/schemas/{model}Contact"} for model in models]}


def _count(
    lowest: int, meaning: str, default: int | None = None, highest: int | None = None
) -> dict[str, Any]:
    found: dict[str, Any] = {"type": "integer", "minimum": lowest, "description": meaning}
    if highest is not None:
        found["maximum"] = highest
    return found if default is None else found | {"default": default}


def simulation_schema() -> dict[str, Any]:
    """Return the schema of a request for one design point."""
    return {
        "type": "object",
        "additionalProperties": False,
        "required": [name for name in DIMENSIONS if name not in DEFAULTS and name != "clearance_ratio"],
        "properties": {
            **{name: RATIOS[name].schema(DEFAULTS.get(name)) for name in DIMENSIONS},
            "particle": {
                "type": "boolean",
                "default": True,
                "description": "false: a scene without one; else clearance_ratio is needed",
            },
            "contact": _contact("Instant", "Dwell", "Compliant"),
            "cycles": _count(
                1, "stop after exactly so many excitation cycles from rest; else at the steady response"
            ),
            "history": _count(0, "excitation cycles of the time history", HISTORY_CYCLES, HISTORY_PERIODS),
            "samples": _count(2, "most samples of the time history", SAMPLES),
            "method": {
                "type": "string",
                "enum": ["event", "rk4"],
                "default": "event",
                "description": "rk4 needs cycles",
            },
            "starts": _count(
                0,
                "number of initial states whose steady responses are compared; the first is rest",
                0,
                STARTS_LIMIT,
            ),
            "seed": _count(0, "seed of the random initial states", 0, SEED_LIMIT),
        },
    }


def comparison_schema() -> dict[str, Any]:
    """Return the schema of a request for a comparison under a record."""
    return {
        "type": "object",
        "additionalProperties": False,
        "properties": {
            "record": {
                "default": "loma-prieta",
                "description": "id of a record, an earthquake's name, or what to generate",
                "anyOf": [{"type": "string"}, {"type": "object", "required": ["kanai_tajimi"]}],
            },
            **{name: quantity.schema(default) for name, (quantity, default) in QUANTITIES.items()},
            "tmd_criterion": {"type": "string", "enum": list(CRITERIA), "default": "den_hartog"},
            "cases": {"type": "array", "minItems": 1, "items": {"type": "string", "enum": list(CASES)}},
            "starts": _count(0, "perturbed starts, whose spread is given", 16, MOST_STARTS),
            "seed": _count(0, "of their draw", 0),
            "contact": _contact("Instant", "Dwell"),
        },
    }
