"""What schemathesis is told of a service that has something to ask: ids of studies and records that are there."""

import os
from typing import Any

import schemathesis
from hypothesis import strategies as st

KNOWN = {
    "study_id": os.environ.get("FUZZ_STUDIES", "").split(","),
    "record_id": ["northridge", "el-centro"],
    "key": ["zarr.json", "amplitude_ratio/c/0/0/0/0/0/0", "status/zarr.json"],
}


@schemathesis.hook
def before_call(context: Any, case: Any, kwargs: Any) -> None:
    """Name what is there in three of four requests, chosen by the request alone so that a failure can be repeated."""
    chosen = hash(repr((case.query, case.body, case.operation.label)))
    for name, known in KNOWN.items():
        if name in (case.path_parameters or {}) and chosen % 4:
            case.path_parameters[name] = known[chosen // 4 % len(known)]


@schemathesis.hook
def before_generate_query(context: Any, strategy: Any) -> Any:
    """Name dimensions that the studies have, in every other request for a map."""
    if not context.operation.path.endswith("resonance-map"):
        return strategy
    axes = st.sampled_from(["frequency_ratio", "friction_ratio", "clearance_ratio", "clearance_m"])
    return strategy | st.fixed_dictionaries({"x": axes, "y": axes})
