"""Examples in the OpenAPI document; the tests send each of them to a running service."""

from typing import Any

from damperlab.service.schemas import comparison_schema, simulation_schema
from damperlab.studies.definition import Study
from damperlab.studies.examples import EXAMPLES, SUITE
from damperlab.studies.ground.schema import suite_json_schema
from damperlab.studies.text import MOST_STUDIES
from damperlab.studies.vocabulary import STATES

_LINEAR_YAML = """\
name: no-damper
damping_ratio: 0.0038
axes:
  frequency_ratio: {start: 0.5, stop: 2, num: 31, spacing: log}
  friction_ratio: 0
particle: false
"""

_EITHER = [{"$ref": f"#/components/schemas/{kind}"} for kind in ("Study", "Suite")]

STUDY_BODY: dict[str, Any] = {
    "required": True,
    "description": "A study: what is varied, and how each point is computed; or a list of studies.",
    "content": {
        "application/json": {
            "schema": {
                "anyOf": [
                    *_EITHER,
                    {"type": "array", "minItems": 1, "maxItems": MOST_STUDIES, "items": {"anyOf": _EITHER}},
                ]
            },
            "examples": {
                f"example-{number}": {"summary": example["name"], "value": example}
                for number, example in enumerate((*EXAMPLES, SUITE), 1)
            },
        },
        "application/yaml": {
            "schema": {"type": "string"},
            "examples": {"linear": {"summary": "The structure alone", "value": _LINEAR_YAML}},
        },
    },
}

SIMULATE_BODY: dict[str, Any] = {
    "required": True,
    "description": "One design point.",
    "content": {
        "application/json": {
            "schema": {"$ref": "#/components/schemas/Simulation"},
            "examples": {
                "structure": {
                    "summary": "The structure alone at resonance, until its response is steady",
                    "value": {"damping_ratio": 0.0038, "frequency_ratio": 1.0, "particle": False},
                },
                "hybrid": {
                    "summary": "Particle and friction, ten excitation cycles from rest, with a time history",
                    "value": {
                        "damping_ratio": 0.0038,
                        "frequency_ratio": 1.0,
                        "friction_ratio": 0.2,
                        "clearance_ratio": 10,
                        "restitution": 0.47,
                        "mass_ratio": 0.1,
                        "cycles": 10,
                        "history": 200,
                    },
                },
            },
        }
    },
}


RECORD_BODY: dict[str, Any] = {
    "required": True,
    "description": "A PEER AT2 file, two columns of time and acceleration, or what to generate.",
    "content": {
        "text/plain": {
            "schema": {"type": "string"},
            "examples": {
                "at2": {
                    "summary": "A PEER file",
                    "value": "PEER NGA STRONG MOTION DATABASE RECORD\nA quake, 1/1/2000, A station, 90\n"
                    "ACCELERATION TIME SERIES IN UNITS OF G\nNPTS=   4, DT=   .0100 SEC,\n"
                    "  .1000000E-01 -.3000000E-01  .2000000E-01  .0000000E+00\n",
                }
            },
        },
        "text/csv": {
            "schema": {"type": "string"},
            "examples": {
                "columns": {
                    "summary": "Two columns, the unit in the heading",
                    "value": "time (s), acceleration (g)\n0, 0\n0.01, 0.1\n0.02, -0.05\n0.03, 0\n",
                }
            },
        },
        "application/json": {
            "schema": {"type": "object"},
            "examples": {
                "kanai-tajimi": {
                    "summary": "An artificial record",
                    "value": {"kanai_tajimi": {"seed": 1, "duration_s": 20, "peak_g": 0.3}},
                }
            },
        },
    },
}

COMPARISON_BODY: dict[str, Any] = {
    "required": True,
    "description": "A record, and what of the paper's prototype is different. Physical units: kg, Hz, m, N.",
    "content": {
        "application/json": {
            "schema": {"$ref": "#/components/schemas/EarthquakeComparison"},
            "examples": {
                "table-a1": {"summary": "Table A1 under Loma Prieta", "value": {"record": "loma-prieta"}},
                "building": {
                    "summary": "Another structure, half the record",
                    "value": {
                        "record": "el-centro",
                        "scale": 0.5,
                        "mass_kg": 1000,
                        "natural_frequency_hz": 1.0,
                        "damping_ratio": 0.01,
                        "particle_mass_kg": 50,
                        "clearance_m": 0.1,
                        "friction_force_n": 200,
                        "starts": 4,
                        "contact": {"model": "dwell", "contact_time": 0.05},
                    },
                },
            },
        }
    },
}


def complete(document: dict[str, Any]) -> None:
    """Correct the framework's OpenAPI document in place.

    Bodies are read by hand, so the schema of a study and of its parts is added by hand; the framework's own form of
    a validation error goes, because no route answers with it.
    """
    schemas = document.setdefault("components", {}).setdefault("schemas", {})
    for name in ("HTTPValidationError", "ValidationError"):
        schemas.pop(name, None)
    study = Study.model_json_schema(ref_template="#/components/schemas/{model}")
    schemas.update(study.pop("$defs", {}))
    schemas["Study"] = study
    schemas["Suite"] = suite_json_schema()
    schemas["Simulation"] = simulation_schema()
    schemas["EarthquakeComparison"] = comparison_schema()
    for operations in document["paths"].values():
        for operation in operations.values():
            if "HTTPValidationError" in str(operation["responses"].get("422")):
                del operation["responses"]["422"]


RECORD: dict[str, Any] = {
    "content": {
        "application/json": {
            "schema": {
                "type": "object",
                "required": ["id", "name", "state", "points_total", "points_done", "points_failed", "digest"],
                "properties": {
                    "id": {
                        "type": "string",
                        "description": "first 12 hex digits of the digest; -2 behind them for version 2",
                    },
                    "name": {"type": "string"},
                    "state": {"enum": list(STATES)},
                    "phase": {
                        "enum": [
                            "queued",
                            "starting",
                            "compiling",
                            "waiting",
                            "running",
                            "done",
                            "cancelled",
                            "failed",
                        ],
                        "description": "the state, or what a running study does before its blocks",
                    },
                    "phase_done": {"type": ["integer", "null"], "description": "kernels compiled"},
                    "phase_total": {"type": ["integer", "null"], "description": "kernels to compile"},
                    "points_total": {"type": "integer"},
                    "points_done": {"type": "integer"},
                    "points_failed": {"type": "integer"},
                    "points_reused": {
                        "type": "integer",
                        "description": "Points reused from earlier studies.",
                    },
                    "blocks_total": {"type": "integer"},
                    "blocks_done": {"type": "integer"},
                    "created": {"type": "string", "format": "date-time"},
                    "started": {"type": ["string", "null"], "format": "date-time"},
                    "finished": {"type": ["string", "null"], "format": "date-time"},
                    "seconds_left": {
                        "type": ["number", "null"],
                        "description": "expected wall time to the end [s]",
                    },
                    "definition": {
                        "type": "object",
                        "description": "the study; submit it again to get this record",
                    },
                    "digest": {"type": "string"},
                    "message": {"type": ["string", "null"]},
                    "version": {
                        "type": "integer",
                        "description": "1 as submitted; computed again by a later solver, it gets the next",
                    },
                    "outdated": {
                        "type": "boolean",
                        "description": "another solver than today's computed the results; POST /recompute",
                    },
                },
            }
        }
    },
}
