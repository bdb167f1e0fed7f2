"""JSON schemas of request bodies that damperlab reads without FastAPI, for the OpenAPI document."""

from typing import Any, get_args

from damperlab.service.parameters import described
from damperlab.service.simulation_request import HISTORY_CYCLES, SAMPLES
from damperlab.studies.field import fields_of
from damperlab.studies.ground.generated import SCHEMAS
from damperlab.studies.ground.quantities import QUANTITIES
from damperlab.studies.quantity import QUANTITY_OF, RATIOS
from damperlab.studies.questions import Compared, Simulated
from damperlab.studies.variables import BEFORE, DIMENSIONS
from damperlab.studies.vocabulary import DEFAULTS

TYPES: dict[Any, str] = {int: "integer", float: "number"}
"""JSON type of a field by its Python type. Fields of every other Python type are strings in JSON."""


def _contact(*models: str) -> dict[str, Any]:
    return {"anyOf": [{"$ref": f"#/components/schemas/{model}Contact"} for model in models]}


def _fields(question: type, **defaults: Any) -> dict[str, Any]:
    """Return the JSON schema of each field of a dataclass.

    Parameters
    ----------
    question : type
        The dataclass.
    **defaults
        Defaults that replace the defaults of the dataclass, by name of the field.
    """
    found: dict[str, Any] = {}
    for each in fields_of(question):
        about: dict[str, Any] = {"description": described(each)}
        if each.is_list:
            about |= {"type": "array", "minItems": 1, "items": {"type": "string", "enum": list(each.allowed)}}
        elif names := get_args(each.core):
            about |= {"type": "string", "enum": list(names)}
        else:
            about["type"] = TYPES.get(each.core, "string")
        limits = (("minimum", each.least), ("maximum", each.most))
        about |= {name: int(limit) for name, limit in limits if limit is not None}
        default = defaults.get(each.name, each.default)
        found[each.name] = about if default is None else about | {"default": default}
    return found


def _or_null(schema: dict[str, Any]) -> dict[str, Any]:
    return schema | {"type": [schema["type"], "null"]}


def simulation_schema() -> dict[str, Any]:
    """Return the JSON schema of a request for the computation of one design point."""
    return {
        "type": "object",
        "additionalProperties": False,
        "required": [name for name in DIMENSIONS if name not in DEFAULTS and name != "clearance_ratio"],
        "properties": {
            **{name: RATIOS[name].schema(DEFAULTS.get(name)) for name in DIMENSIONS},
            "particle": {
                "type": "boolean",
                "default": True,
                "description": "false for a scene without a particle; otherwise clearance_ratio is required",
            },
            "contact": _contact("Instant", "Dwell", "Compliant"),
            **{name: QUANTITY_OF[name].schema(0.0) for name in BEFORE},
            **_fields(Simulated, history=HISTORY_CYCLES, samples=SAMPLES),
            "cycles": _or_null(_fields(Simulated)["cycles"]),
        },
    }


def comparison_schema() -> dict[str, Any]:
    """Return the JSON schema of a request for a comparison of dampers under a ground-motion record."""
    return {
        "type": "object",
        "additionalProperties": False,
        "properties": {
            **{name: _or_null(quantity.schema(default)) for name, (quantity, default) in QUANTITIES.items()},
            **_fields(Compared),
            "record": {
                "default": Compared.record,
                "description": "Id of a record, an earthquake's name, or the definition of a record to "
                "generate.",
                "anyOf": [
                    {"type": "string"},
                    *(
                        {"type": "object", "required": [way], "properties": {way: schema}}
                        for way, schema in SCHEMAS.items()
                    ),
                ],
            },
            "contact": _contact("Instant", "Dwell"),
        },
    }
