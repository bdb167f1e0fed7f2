"""Studies computed where a test runs, all of their points at once."""

import json

import xarray as xr

from damperlab.studies.definition import Study
from damperlab.studies.ground.suite import Suite
from damperlab.studies.plan import Block
from damperlab.studies.variables import STANDARD, VARIABLES
from damperlab.worker.block import solve_block
from damperlab.worker.ground.block import solve_suite_block
from damperlab.worker.steady.response.measures import INTEGRATED

LEAN = [name for name in STANDARD if name not in INTEGRATED]
"""What needs no integral over a motion: the kernels of a design's search compute it."""


def solved(study: Study | Suite) -> xr.Dataset:
    """Give the cube of a study; records are those that come back from a store with it."""
    block = Block.whole(study.shape)
    if isinstance(study, Suite):
        files = study.attachments()
        values = solve_suite_block(study, block, lambda source: source.read(files[source.key]))
    else:
        values = solve_block(study, block)
    cube = xr.Dataset(
        {name: (tuple(study.coordinates), array) for name, array in values.items()},
        study.coordinates,
        {"study": json.dumps(study.document())},
    )
    for name in cube.data_vars.keys() & VARIABLES.keys():
        variable = VARIABLES[str(name)]
        flags = {"flag_values": [0]} if variable.flags else {}
        cube[name].attrs = {"units": variable.units, "long_name": variable.long_name, **flags}
    for name, labels in study.labels.items():
        cube[name].attrs = labels
    return cube
