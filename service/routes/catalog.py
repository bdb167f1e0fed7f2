"""What a study can be made of: the named studies, the dimensions, the variables and their meanings."""

from typing import Any

from fastapi import APIRouter

from damperlab.service.answer_schemas import gives
from damperlab.service.documents import Document
from damperlab.studies.ground.variables import DIMENSIONS as SUITE_DIMENSIONS
from damperlab.studies.ground.variables import VARIABLES as SUITE_VARIABLES
from damperlab.studies.named import named_specifications, named_texts
from damperlab.studies.physical import QUANTITIES
from damperlab.studies.quantity import RATIOS, Quantity
from damperlab.studies.text import load_text
from damperlab.studies.variables import DIMENSION_LONG_NAMES, VARIABLES, ResponseClass, Status, Variable
from damperlab.studies.vocabulary import CRITERIA, DEFAULTS, OBJECTIVES, RESPECTS

router = APIRouter(prefix="/api/v1", tags=["studies"])


@router.get(
    "/catalog",
    response_class=Document,
    responses={200: gives("Catalog")},
    summary="Named studies, dimensions, variables, meanings",
)
def catalog() -> Document:
    """Say what a study can be made of and what its results mean: all that a form or a legend needs."""
    return Document(
        {
            "studies": [_study(name, text) for name, text in named_texts().items()],
            "specifications": [_study(name, text) for name, text in named_specifications().items()],
            "dimensions": [
                _bounds(quantity) | {"long_name": DIMENSION_LONG_NAMES[name], "default": DEFAULTS.get(name)}
                for name, quantity in RATIOS.items()
            ],
            "physical": [_bounds(quantity) | {"long_name": quantity.meaning} for quantity in QUANTITIES],
            "variables": [_variable(variable) for variable in VARIABLES.values()],
            "suite": {
                "dimensions": [
                    {"name": name, "units": units, "long_name": words}
                    for name, (units, words) in SUITE_DIMENSIONS.items()
                ],
                "variables": [_variable(variable) for variable in SUITE_VARIABLES.values()],
            },
            "status": {str(status.value): status.sentence for status in Status},
            "response_class": {
                str(kind.value): {"name": kind.name.lower().replace("_", " "), "sentence": kind.sentence}
                for kind in ResponseClass
            },
            "objectives": OBJECTIVES,
            "respects": {name: meaning for name, (_, meaning) in RESPECTS.items()},
            "tunings": CRITERIA,
        }
    )


def _bounds(quantity: Quantity) -> dict[str, Any]:
    return {"name": quantity.name, "lowest": quantity.lowest, "highest": quantity.highest}


def _variable(variable: Variable) -> dict[str, Any]:
    return {
        "name": variable.name,
        "units": variable.units,
        "long_name": variable.long_name,
        "doc": variable.doc,
        "coded": variable.flags is not None,
    }


def _study(name: str, text: bytes) -> dict[str, Any]:
    """Give a named study or specification as it was written, and the comment that it opens with."""
    opening = []
    for line in text.decode().splitlines():
        if not line.startswith("#"):
            break
        opening.append(line.removeprefix("#").strip())
    about = [paragraph.strip() for paragraph in "\n".join(opening).split("\n\n")]
    return {
        "name": name,
        "about": [" ".join(paragraph.split()) for paragraph in about if paragraph],
        "definition": load_text(text, "yaml"),
    }
