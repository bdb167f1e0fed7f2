"""Examples for the OpenAPI document. The tests send each example to a running service."""

from typing import Any

from damperlab.service.answer_types import declared_schemas
from damperlab.service.problems import PROBLEM_SCHEMA, documented
from damperlab.service.schemas import comparison_schema, simulation_schema
from damperlab.service.security.caller import SAFE_METHODS, scope_of
from damperlab.service.security.sessions import COOKIE
from damperlab.studies.definition import Study
from damperlab.studies.examples import EXAMPLES, SUITE
from damperlab.studies.ground.suite_reading import suite_json_schema
from damperlab.studies.named import named_specifications
from damperlab.studies.specification.schema import specification_schema
from damperlab.studies.text import MOST_STUDIES

EDGE = (400, 408, 421, 422, 431, 503)
"""Error statuses of any request: malformed, slow, wrong host, invalid parameters, long header, service unavailable."""
WITH_KEY = (401, 403, 429)
"""Error statuses of requests that need an access key: no valid key, missing scope, too many requests."""

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
    "description": "A study: the varied quantities, and the method of computing each point; or a list of studies.",
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
    "description": "A PEER AT2 file, two columns of time and acceleration, or a record to generate.",
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
                },
                "sweep": {
                    "summary": "A swept sine of the base",
                    "value": {
                        "sweep": {
                            "start_hz": 2,
                            "stop_hz": 3,
                            "rate_hz_per_s": 0.1,
                            "base_amplitude_m": 0.001,
                        }
                    },
                },
                "random-vibration": {
                    "summary": "Random vibration of the base",
                    "value": {
                        "random_vibration": {
                            "frequency_hz": [5, 50],
                            "psd_g2_per_hz": [0.002, 0.002],
                            "duration_s": 20,
                            "seed": 1,
                        }
                    },
                },
                "shock": {
                    "summary": "A shock",
                    "value": {"shock": {"shape": "half_sine", "peak_g": 15, "duration_ms": 11}},
                },
            },
        },
    },
}

SPECIFICATION_BODY: dict[str, Any] = {
    "required": True,
    "description": "A specification: requirements, ranges of the damper, and tolerances.",
    "content": {
        "application/json": {
            "schema": {"$ref": "#/components/schemas/Specification"},
            "examples": {
                "floor": {
                    "summary": "A floor at 8 Hz, in SI units; the design chooses the friction force",
                    "value": {
                        "name": "floor",
                        "structure": {"mass_kg": 40, "natural_frequency_hz": 8, "damping_ratio": 0.05},
                        "excitation": {
                            "base_amplitude_m": 0.001,
                            "frequency_hz": {"start": 7.5, "stop": 8.5},
                        },
                        "choose": {"friction_force_n": {"start": 0, "stop": 60}},
                        "clearance_m": 0.005,
                        "particle_mass_kg": 4,
                        "restitution": 0.5,
                        "tolerances": {"friction_force_n": "10%"},
                        "limits": {"displacement_m": 0.006},
                        "budget_points": 2000,
                        "builds": 4,
                    },
                }
            },
        },
        "application/yaml": {
            "schema": {"type": "string"},
            "examples": {
                name: {"summary": f"The named specification {name}", "value": text.decode()}
                for name, text in named_specifications().items()
            },
        },
    },
}

COMPARISON_BODY: dict[str, Any] = {
    "required": True,
    "description": "A record, and the values that differ from the paper's prototype, in kg, Hz, m and N.",
    "content": {
        "application/json": {
            "schema": {"$ref": "#/components/schemas/EarthquakeComparison"},
            "examples": {
                "table-a1": {"summary": "Table A1 under Loma Prieta", "value": {"record": "loma-prieta"}},
                "building": {
                    "summary": "Another structure, the record scaled by 0.5",
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


FIT_BODY: dict[str, Any] = {
    "required": True,
    "description": "A measured frequency response as a table of text, known values of the prototype, and "
    "parameters to estimate.",
    "content": {
        "application/json": {
            "schema": {"$ref": "#/components/schemas/Fit"},
            "examples": {
                "friction": {
                    "summary": "The friction of a structure without a particle",
                    "value": {
                        "measured": "frequency (Hz), amplitude (mm)\n2.3, 6.1\n2.4, 10.2\n2.5, 16.4\n2.6, 11.8\n2.7, 7.6\n",
                        "structure": {
                            "particle": False,
                            "damping_ratio": 0.02,
                            "physical": {"natural_frequency_hz": 2.5, "base_amplitude_m": 0.001},
                        },
                        "fit": {"friction_ratio": [0, 0.7]},
                        "deviation": 0.05,
                    },
                },
            },
        }
    },
}


def complete(document: dict[str, Any]) -> None:
    """Complete the OpenAPI document of FastAPI in place.

    Schemas of request bodies, answers and problem documents are added, and each operation gets the common
    error responses. FastAPI's schemas of validation errors are removed.
    """
    from damperlab.studies.fit.document import fit_schema

    schemas = document.setdefault("components", {}).setdefault("schemas", {})
    for name in ("HTTPValidationError", "ValidationError"):
        schemas.pop(name, None)
    study = Study.model_json_schema(ref_template="#/components/schemas/{model}")
    by_hand = {
        "Study": study,
        "Suite": suite_json_schema(),
        "Simulation": simulation_schema(),
        "EarthquakeComparison": comparison_schema(),
        "Specification": specification_schema(),
        "Fit": fit_schema(),
        "Problem": PROBLEM_SCHEMA,
    }
    for some in (study.pop("$defs", {}), by_hand, declared_schemas()):
        twice = schemas.keys() & some.keys()
        if twice:
            raise ValueError(
                f"two schemas have one name, and one would take the other's place: {sorted(twice)}"
            )
        schemas.update(some)
    document["components"]["securitySchemes"] = {
        "key": {
            "type": "http",
            "scheme": "bearer",
            "description": "A key made by `damperlab admin keys create`.",
        },
        "session": {"type": "apiKey", "in": "cookie", "name": COOKIE},
    }
    for path, operations in document["paths"].items():
        for method, operation in operations.items():
            _complete_operation(path, method.upper(), operation)


def _complete_operation(path: str, method: str, operation: dict[str, Any]) -> None:
    responses = operation["responses"]
    if "HTTPValidationError" in str(responses.get("422")):
        del responses["422"]
    statuses = [*EDGE]
    if scope_of(method, path) is not None:
        statuses += WITH_KEY
        # no key is required on loopback
        operation["security"] = [{}, {"key": []}, {"session": []}]
    if method not in SAFE_METHODS:
        statuses += (403, 415)
    elif "application/json" in responses.get("200", {}).get("content", {}):
        responses["304"] = {"description": "The answer has not changed: its ETag is in If-None-Match."}
    for status, response in documented(*statuses).items():
        responses.setdefault(str(status), response)
    operation["responses"] = dict(sorted(responses.items()))
