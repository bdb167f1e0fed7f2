"""Examples in the OpenAPI document; the tests send each of them to a running service."""

from typing import Any

_MAP_JSON = {
    "name": "friction-alone",
    "damping_ratio": 0.0038,
    "axes": {
        "friction_ratio": [0.0, 0.2, 0.4, 0.6],
        "frequency_ratio": {"start": 0.9, "stop": 1.1, "num": 5, "spacing": "linear"},
    },
    "particle": False,
}
_HYBRID_JSON = {
    "name": "hybrid-at-resonance",
    "damping_ratio": 0.0038,
    "axes": {
        "clearance_ratio": [5.0, 10.0],
        "friction_ratio": [0.2, 0.6],
        "restitution": 0.47,
        "mass_ratio": 0.1,
        "frequency_ratio": 1.0,
    },
    "steady": {"max_cycles": 500},
}
_LINEAR_YAML = """\
name: no-damper
damping_ratio: 0.0038
axes:
  frequency_ratio: {start: 0.5, stop: 2, num: 31, spacing: log}
  friction_ratio: 0
particle: false
"""

STUDY_BODY: dict[str, Any] = {
    "required": True,
    "description": "A study; docs and /openapi.json name every key.",
    "content": {
        "application/json": {
            "schema": {"type": "object"},
            "examples": {
                "friction": {"summary": "Friction alone, over frequency", "value": _MAP_JSON},
                "hybrid": {"summary": "Particle and friction at resonance", "value": _HYBRID_JSON},
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
            "schema": {"type": "object"},
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

RECORD: dict[str, Any] = {
    "content": {
        "application/json": {
            "schema": {
                "type": "object",
                "required": ["id", "name", "state", "points_total", "points_done", "points_failed", "digest"],
                "properties": {
                    "id": {"type": "string", "description": "first 12 hex digits of the digest"},
                    "name": {"type": "string"},
                    "state": {"enum": ["queued", "running", "done", "cancelled", "failed"]},
                    "points_total": {"type": "integer"},
                    "points_done": {"type": "integer"},
                    "points_failed": {"type": "integer"},
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
                },
            }
        }
    },
}
