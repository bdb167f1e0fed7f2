"""What schemathesis is told of a service that has something to ask: ids of what is there now."""

import json
import os
from pathlib import Path
from typing import Any

import schemathesis
from hypothesis import strategies as st

KEYS = ("zarr.json", "amplitude_ratio/c/0/0/0/0/0/0", "status/zarr.json")
"""Of the cube of a study that is no suite."""


@schemathesis.hook
def before_call(context: Any, case: Any, kwargs: Any) -> None:
    """Name what is there in three of four requests, chosen by the request alone so that a failure can be repeated."""
    asked = case.path_parameters or {}
    chosen = hash(repr((case.query, case.body, asked, case.operation.label)))
    there = json.loads(Path(os.environ["FUZZ_THERE"]).read_text())
    if case.operation.method.upper() == "GET":
        there["study_id"].append("curve")  # a name is enough to look
    for name, known in there.items():
        if name in asked and known and chosen % 4:
            asked[name] = known[chosen // 4 % len(known)]
    if "key" in asked and chosen % 4:
        harmonic = asked["study_id"] in there["study_id"][: int(os.environ["FUZZ_HARMONIC"])]
        asked["key"] = KEYS[chosen // 64 % len(KEYS)] if harmonic else "zarr.json"


@schemathesis.hook
def before_generate_query(context: Any, strategy: Any) -> Any:
    """Name dimensions that the studies have, in every other request for a map."""
    if not context.operation.path.endswith("resonance-map"):
        return strategy
    axes = st.sampled_from(["frequency_ratio", "friction_ratio", "clearance_ratio", "clearance_m"])
    return strategy | st.fixed_dictionaries({"x": axes, "y": axes})
