"""JSON schemas of the answers, for the OpenAPI document.

An answer is made from the tables of variables, states and cases, so its schema is too; nothing is checked against it while
an answer is sent, since most of an answer is arrays. A number that is not finite is null in JSON.
"""

from collections.abc import Iterable
from dataclasses import fields
from typing import Any

from pydantic import TypeAdapter

from damperlab.service.questions.every import EVERY
from damperlab.service.questions.refinement import Refinement
from damperlab.service.questions.shapes import InShort, Notes
from damperlab.studies.kinds import EVERY_DIMENSION
from damperlab.studies.store.record import PREPARATIONS, Record
from damperlab.studies.store.reuse.differences import Differences
from damperlab.studies.variables import VARIABLES, Variable
from damperlab.studies.vocabulary import CASES, CRITERIA, OBJECTIVES, RESPECTS, SCOPES, STATES
from damperlab.worker.ground.response import GroundResponse

Schema = dict[str, Any]

TEXT: Schema = {"type": "string"}
FLAG: Schema = {"type": "boolean"}
COUNT: Schema = {"type": "integer", "minimum": 0}
NUMBER: Schema = {"type": ["number", "null"]}
TABLE: Schema = {"type": "object", "description": "Beside one another, by name."}
TEXTS: Schema = {"type": "array", "items": TEXT}
NUMBERS: Schema = {"type": "array", "items": NUMBER}
RANGE: Schema = {"type": "array", "items": NUMBER, "minItems": 2, "maxItems": 2}

FORCES = ("spring", "damping", "friction", "excitation")
WITHOUT_DEFINITION = ("definition", "provenance")
"""What a list leaves out of its records."""

_RECORD_WORDS = {
    "id": "First 12 hex digits of the digest; -2 behind them for version 2.",
    "phase": "The state, or what a running study does before its blocks.",
    "phase_done": "Kernels compiled.",
    "phase_total": "Kernels to compile.",
    "points_reused": "Points reused from earlier studies.",
    "seconds_left": "Expected wall time to the end, in seconds.",
    "definition": "The study; submit it again to get this record.",
    "version": "1 as submitted; computed again by a later solver, it gets the next.",
    "outdated": "Another solver than today's computed the results; POST /recompute.",
    "dimensions": "Those of the cube, in its order.",
    "priority": "Of the studies that wait the one with the highest begins first.",
    "submitted_by": "Owner of the key that it was submitted with; null where no keys are asked for.",
}


def gives(name: str, description: str = "The answer", **headers: str) -> Schema:
    """Declare one of `answer_schemas` as what a status answers with; `headers` say what its headers mean."""
    declared: Schema = {"description": description, "content": {"application/json": {"schema": of(name)}}}
    if headers:
        declared["headers"] = {
            key.replace("_", "-"): {"description": text, "schema": TEXT} for key, text in headers.items()
        }
    return declared


def of(name: str) -> Schema:
    """Refer to one of the document's schemas."""
    return {"$ref": f"#/components/schemas/{name}"}


def _object(optional: Iterable[str] = (), /, **properties: Schema) -> Schema:
    """Describe an object; a later version may add keys to it."""
    lacking = set(optional)
    required = [name for name in properties if name not in lacking]
    return {"type": "object", "required": required, "properties": properties}


def _by_name(values: Schema, names: Iterable[str] = ()) -> Schema:
    named = {"propertyNames": {"enum": list(names)}} if names else {}
    return {"type": "object", "additionalProperties": values, **named}


def _list(items: Schema) -> Schema:
    return {"type": "array", "items": items}


def _or_null(schema: Schema) -> Schema:
    return {"anyOf": [schema, {"type": "null"}]}


def _enum(names: Iterable[str]) -> Schema:
    return {"type": "string", "enum": list(names)}


def _record() -> Schema:
    found = TypeAdapter(Record).json_schema(mode="serialization")
    properties: Schema = {
        name: {key: value for key, value in each.items() if key != "title"}
        for name, each in found["properties"].items()
    }
    properties["state"] = _enum(STATES)
    properties["phase"] = _enum((*PREPARATIONS, *STATES))
    properties["dimensions"] = TEXTS
    properties["submitted_by"] = _or_null(TEXT)
    for name, words in _RECORD_WORDS.items():
        properties[name] = properties[name] | {"description": words}
    return _object(**properties)


def _without(schema: Schema, names: Iterable[str], **more: Schema) -> Schema:
    left = set(names)
    return _object(**{key: value for key, value in schema["properties"].items() if key not in left}, **more)


def _measured(variable: Variable) -> Schema:
    coded = variable.flags is not None
    return {
        **({"type": "integer"} if coded else NUMBER),
        "description": f"{variable.long_name} [{variable.units}]",
    }


def schema_of(kind: Any) -> Schema:
    """Make the schema of a type of `questions.shapes`, whole, without titles and without what readers of the code are told."""
    found = TypeAdapter(list[kind]).json_schema(mode="serialization")
    schema: Schema = _whole(found["items"], found.get("$defs", {}))
    return schema


def _whole(schema: Any, parts: Schema) -> Any:
    """Put the parts where they are referred to, and types that are but names beside one another."""
    if isinstance(schema, list):
        return [_whole(each, parts) for each in schema]
    if not isinstance(schema, dict):
        return schema
    about = {key: value for key, value in schema.items() if not (key == "title" and isinstance(value, str))}
    if (reference := about.pop("$ref", None)) is not None:
        part = parts[reference.rpartition("/")[2]]
        about = {key: value for key, value in part.items() if key not in ("title", "description")} | about
    if about.get("additionalProperties") is True:
        del about["additionalProperties"]
    found = {key: _whole(value, parts) for key, value in about.items()}
    choices = found.get("anyOf", ())
    if choices and all(each.keys() == {"type"} for each in choices):
        del found["anyOf"]
        found["type"] = [each["type"] for each in choices]
    return found


_BRIEF, _NOTES = schema_of(InShort), schema_of(Notes)
_GROUND_MOTION: Schema = {
    "id": TEXT,
    "name": TEXT,
    "source": TEXT,
    "samples": COUNT,
    **dict.fromkeys(
        ("step_s", "duration_s", "peak_acceleration_m_s2", "peak_acceleration_g", "peak_velocity_m_s"), NUMBER
    ),
    "peak_displacement_m": NUMBER,
    "digest": TEXT,
}
_BOUNDS: Schema = {"name": TEXT, "lowest": NUMBER, "highest": NUMBER, "long_name": TEXT}


_BUILT: Schema = {
    "type": "object",
    "description": "A damper in drawing values and in ratios.",
    "additionalProperties": {"type": ["number", "string", "null"]},
}
_WORST = _object(
    (
        "measure",
        "ratio",
        "frequency_hz",
        "frequency_ratio",
        "base_amplitude_m",
        "error",
        "excitation",
        "record",
        "record_name",
        "scale",
    ),
    measure=TEXT,
    value=NUMBER,
    error=NUMBER,
    units=TEXT,
    ratio=NUMBER,
    frequency_ratio=NUMBER,
    frequency_hz=NUMBER,
    base_amplitude_m=NUMBER,
    excitation={"type": ["string", "null"], "description": "Its name, where there are several."},
    record={
        "type": ["string", "null"],
        "description": "The ground-motion record, of a design under records.",
    },
    record_name={
        "type": ["string", "null"],
        "description": "What it is called: its id, or what it was generated from.",
    },
    scale=NUMBER,
)
_ESTIMATED: dict[str, Schema] = {
    "measured": TEXT,
    "confidence": NUMBER,
    "parameters": _by_name(
        _object(value=NUMBER, low=NUMBER, high=NUMBER, deviation=NUMBER, range=RANGE, determined=FLAG)
    ),
    "correlation": _by_name(_by_name(NUMBER)),
    "cannot_tell_apart": _list(TEXTS),
    "chi_square": NUMBER,
    "degrees_of_freedom": COUNT,
    "probability": NUMBER,
    "widening": NUMBER,
    "others": _list(_by_name(NUMBER)),
    "evaluations": COUNT,
    "words": TEXTS,
}
_FITTED = _object(
    **_ESTIMATED,
    rows=_list(_by_name(NUMBER)),
    outliers=_list(COUNT),
    units=_by_name(TEXT),
    study={"type": "object", "description": "The prototype with its estimated parameters, as a study."},
)
_FITTED_HISTORY = _object(
    **_ESTIMATED,
    stretch_s=NUMBER,
    rows_counted=COUNT,
    correlated=NUMBER,
    time_s=NUMBERS,
    measured_m=NUMBERS,
    model_m=NUMBERS,
    deviation_m=NUMBERS,
    study={
        "type": ["object", "null"],
        "description": "The prototype as a study around its natural frequency; null where nothing says how its base moves.",
    },
)
_DESIGN_ANSWER = _object(
    # of answers that were kept before there were such
    ("starts", "amplitudes", "masses", "ended", "no_damper", "verdict", "notes"),
    name=TEXT,
    digest=TEXT,
    design=_BUILT,
    worst=_WORST,
    nominal=_WORST,
    excitations=_list(_WORST),
    feasible=FLAG,
    limits=_list(
        _object(
            limit=TEXT,
            allowed=NUMBER,
            reached=NUMBER,
            at_most=NUMBER,
            kept=FLAG,
            binds=FLAG,
            relax_to=NUMBER,
            frequency_ratio=NUMBER,
            frequency_hz=NUMBER,
            excitation={"type": ["string", "null"]},
            record={"type": ["string", "null"]},
            scale=NUMBER,
        )
    ),
    probability=NUMBER,
    probability_interval=_or_null(RANGE),
    builds=COUNT,
    margins=_by_name(_by_name(NUMBER)),
    friction_alone=_or_null(_object(design=_BUILT, worst=_WORST, feasible=FLAG, ratio=NUMBER)),
    particle_alone=_or_null(_object(design=_BUILT, worst=_WORST, feasible=FLAG, ratio=NUMBER)),
    tuned_mass_damper=_or_null(
        _object(
            mass_ratio=NUMBER,
            tuning=NUMBER,
            damping_ratio=NUMBER,
            worst=_WORST,
            detuned=_WORST,
            detuned_by=NUMBER,
            stroke=_WORST,
            detuned_stroke=_WORST,
            feasible=FLAG,
            exceeded=TEXTS,
            ratio=NUMBER,
        )
    ),
    pareto=_list(_by_name(NUMBER)),
    stopped=TEXT,
    left_out=TEXTS,
    confidence=NUMBER,
    points=COUNT,
    budget_points=COUNT,
    verdict=_BRIEF,
    notes=_NOTES,
    words=TEXTS,
    response=_by_name(NUMBERS),
    no_damper=_object(response=_by_name(NUMBERS)),
    starts=_or_null(
        _object(
            count=COUNT,
            frequencies=COUNT,
            several=COUNT,
            where=_list(
                _object(frequency_ratio=NUMBER, attractors=COUNT, highest=NUMBER, responses=_list(TABLE))
            ),
        )
    ),
    amplitudes=_list(
        _object(
            amplitude=NUMBER,
            amplitude_units=TEXT,
            asked=FLAG,
            frequency_ratio=NUMBERS,
            frequency_hz=_or_null(NUMBERS),
            value=NUMBERS,
            ratio=NUMBERS,
            units=TEXT,
            worst=NUMBER,
            worst_ratio=NUMBER,
            worst_frequency_ratio=NUMBER,
            worst_frequency_hz=NUMBER,
        )
    ),
    masses=_list(
        _object(
            design=_BUILT,
            worst=_WORST,
            feasible=FLAG,
            looked_at=COUNT,
            recommended=FLAG,
            lighter_as_good=FLAG,
            tuned_mass_damper=NUMBER,
            particle_alone=NUMBER,
        )
    ),
    ended=_object(("looked_at",), criterion=TEXT, looked_at=COUNT),
    cases=_list(_object(("record_name",), record=TEXT, record_name=TEXT, scale=NUMBER, value=NUMBER)),
    specification={"type": "object"},
)
_DESIGN_LISTED: Schema = {
    "id": TEXT | {"description": "First 12 hex digits of the digest."},
    "name": TEXT,
    "state": _enum(STATES),
    "stage": {"type": ["string", "null"], "description": "What is computed now, in words."},
    "round": COUNT | {"description": "Rounds of studies begun."},
    "points": COUNT | {"description": "Points known when the round began."},
    "points_wanted": COUNT | {"description": "Points of the round's studies."},
    "budget_points": COUNT | {"description": "Most points."},
    "created": TEXT,
    "started": {"type": ["string", "null"]},
    "finished": {"type": ["string", "null"]},
    "message": {"type": ["string", "null"], "description": "Why it failed, or what it waits for."},
    "digest": TEXT,
    "known": _or_null(
        _object(design=_BUILT, worst=_WORST, feasible=FLAG)
        | {"description": "The best so far, as drawn; of a design that is done the one it recommends."}
    ),
}


def answer_schemas() -> dict[str, Schema]:
    """Return the schema of every JSON answer, by name."""
    record = _record()
    summary = _without(record, WITHOUT_DEFINITION)
    refinement = schema_of(Refinement)
    metrics = {name: _measured(variable) for name, variable in VARIABLES.items()}
    case = {each.name: COUNT if each.type in (int, "int") else NUMBER for each in fields(GroundResponse)}
    differences = TypeAdapter(Differences).json_schema(
        mode="serialization", ref_template=of("{model}")["$ref"]
    )
    parts = differences.pop("$defs")
    for each in (differences, *parts.values()):
        each.pop("description", None)
    estimate = _object(
        digest=TEXT, points=COUNT, blocks=COUNT, bytes=COUNT, seconds=NUMBER, seconds_low=NUMBER,
        seconds_high=NUMBER, compiling_seconds=NUMBER, kernels_missing=COUNT, definition={"type": "object"},
        understood=_list(TEXT),
    )  # fmt: skip
    return {
        **parts,
        "Record": record,
        "RecordSummary": summary,
        "Records": _object(studies=_list(of("RecordSummary"))),
        "RecordPage": _object(studies=_list(of("RecordSummary")), cursor={"type": ["string", "null"]}),
        "SubmittedList": _object(studies=_list(_without(summary, ("created",), created=FLAG))),
        "Estimate": estimate,
        "EstimateList": _object(studies=_list(of("Estimate"))),
        "SubmittedBefore": {
            "anyOf": [of(name) for name in ("Record", "SubmittedList", "Estimate", "EstimateList")]
        },
        "Submitted": {"anyOf": [of("Record"), of("SubmittedList")]},
        "Differences": differences,
        "Catalog": _object(
            studies=_list(_object(name=TEXT, about=TEXTS, definition={"type": "object"})),
            specifications=_list(_object(name=TEXT, about=TEXTS, definition={"type": "object"})),
            dimensions=_list(_object(**_BOUNDS, default=NUMBER)),
            physical=_list(_object(**_BOUNDS)),
            variables=_list(_object(name=TEXT, units=TEXT, long_name=TEXT, doc=TEXT, coded=FLAG)),
            suite={"type": "object", "required": ["dimensions", "variables"]},
            status=_by_name(TEXT),
            response_class=_by_name(_object(name=TEXT, sentence=TEXT)),
            objectives=_by_name(TEXT, OBJECTIVES),
            respects=_by_name(TEXT, RESPECTS),
            tunings=_by_name(TEXT, CRITERIA),
        ),
        "StudyAxes": _object(
            study=TEXT,
            axes=_by_name({"type": "array", "items": {"type": ["number", "string"]}}, EVERY_DIMENSION),
            variables=TEXTS,
        ),
        **{question.gives.__name__: schema_of(question.gives) for question in EVERY},
        "Refinement": refinement,
        "FollowUps": _object(
            **refinement["properties"],
            follow_up=_without(record, ("definition",)),
            follow_ups=_list(_without(record, ("definition",))),
        ),
        "RefinementOrFollowUps": {"anyOf": [of("FollowUps"), of("Refinement")]},
        "Readiness": _object(
            phase=_enum(("ready", "compiling")), phase_done=COUNT, phase_total=COUNT, compiling_seconds=NUMBER
        ),
        "Simulated": _object(
            ("attractors", "wall", "settles_after_cycles", "forces", "spectrum"),
            metrics=_object(metrics, **metrics),
            status=TEXT,
            response_class=TEXT,
            state=_by_name(NUMBER),
            events=_by_name(COUNT),
            cycles=COUNT,
            history=_by_name(NUMBERS),
            forces=_by_name(NUMBERS, FORCES)
            | {
                "description": "On the structure over k·Z, at the samples of the history; none of an instantaneous impact."
            },
            spectrum=_by_name(NUMBERS, ("multiple", "amplitude"))
            | {
                "description": "Amplitudes of u over Z at multiples of the excitation's frequency, over its whole cycles."
            },
            settles_after_cycles=NUMBER,
            attractors=_object(
                starts=COUNT, failed=COUNT, decided_by_a_rounding=FLAG, met=_list(TABLE), note=TEXT
            ),
            wall=_by_name(NUMBER),
        ),
        "Promise": _object(
            state=_enum(("computing",)),
            seconds={"type": "number", "minimum": 0, "description": "Since it was asked for."},
            answer=TEXT | {"description": "Path of the answer."},
        ),
        "PromisedAnswer": {
            "anyOf": [of("Simulated"), of("Readiness"), of("Compared"), of("Fitted"), of("FittedHistory")]
        },
        "SimulatedOrReadiness": {"anyOf": [of("Simulated"), of("Readiness")]},
        "GroundMotion": _object(("submitted_by",), **_GROUND_MOTION, submitted_by=TEXT),
        "GroundMotionShown": _object(
            ("submitted_by",),
            **_GROUND_MOTION,
            submitted_by=TEXT,
            time_s=NUMBERS,
            acceleration_m_s2=NUMBERS,
            damping_ratio=NUMBER,
            period_s=NUMBERS,
            pseudo_acceleration_m_s2=NUMBERS,
        ),
        "GroundMotions": _object(records=_list(of("GroundMotion"))),
        "DesignAnswer": _DESIGN_ANSWER,
        "DesignSummary": _object(**_DESIGN_LISTED),
        "DesignPage": _object(designs=_list(of("DesignSummary")), cursor={"type": ["string", "null"]}),
        "Design": _object(
            **_DESIGN_LISTED,
            studies=TEXTS | {"description": "Ids of the round's studies."},
            studies_done=COUNT,
            points_of_round=COUNT | {"description": "Points of the round's studies that are there."},
            specification={"type": "object"},
            answer=_or_null(of("DesignAnswer")),
        ),
        "DesignOrBudget": {
            "anyOf": [
                of("Design"),
                _object(name=TEXT, digest=TEXT, chosen=TEXTS, budget_points=COUNT, understood=TEXTS),
            ]
        },
        "Compared": _object(
            ("histories",),
            histories=_by_name(TABLE, CASES),
            record=_object(**_GROUND_MOTION),
            length_scale_m=NUMBER,
            design=_by_name(NUMBER),
            contact={"type": "object", "required": ["model"]},
            tmd=_or_null(
                _object(criterion=_enum(CRITERIA), mass_ratio=NUMBER, tuning=NUMBER, damping_ratio=NUMBER)
            ),
            cases=_by_name(_object(("spread", "loss_particle_j"), label=TEXT, **case, spread=TABLE), CASES),
            brief=_BRIEF,
            paper_table_a1=_by_name(_by_name(NUMBER), CASES),
            units=_by_name(TEXT),
            note=TEXT,
        ),
        "Fitted": _FITTED,
        "FittedHistory": _FITTED_HISTORY,
        "FittedOrReadiness": {"anyOf": [of("Fitted"), of("FittedHistory"), of("Readiness")]},
        "ComparedOrReadiness": {"anyOf": [of("Compared"), of("Readiness")]},
        "AccuracyReport": {
            "type": "object",
            "required": ["created", "version", "diagrams", "stability", "passed"],
        },
        "AccuracyReports": _object(
            reports=_list(_object(("created", "version"), created=TEXT, version=TEXT, passed=FLAG))
        ),
        "Live": _object(status=_enum(("live",))),
        "Ready": _object(
            status=_enum(("ready",)),
            cluster=_enum(("idle", "running", "lost")),
            cluster_message={"type": ["string", "null"]},
            running=TEXTS,
        ),
        "Session": _object(needed=FLAG, signed_in=FLAG, owner=TEXT, scopes=_list(_enum(SCOPES))),
    }


PROMISED = gives(
    "Promise", "It is computed, and will be found where this says.", Location="Where it will be."
)
"""What a request is answered that prefers a promise to waiting (RFC 7240)."""
