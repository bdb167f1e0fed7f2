"""Route that describes named studies, and the dimensions and variables of every study."""

from typing import Annotated, Any

from typing_extensions import TypedDict

from damperlab.service.answer_types import gives
from damperlab.service.documents import Document
from damperlab.service.routes.strict import strict_router
from damperlab.studies.ground.variables import DIMENSIONS as SUITE_DIMENSIONS
from damperlab.studies.ground.variables import VARIABLES as SUITE_VARIABLES
from damperlab.studies.named import named_specifications, named_texts
from damperlab.studies.physical import QUANTITIES
from damperlab.studies.quantity import RATIOS, Quantity
from damperlab.studies.shapes import Number, Says, Sentences
from damperlab.studies.text import load_text
from damperlab.studies.variables import DIMENSION_LONG_NAMES, VARIABLES, ResponseClass, Status, Variable
from damperlab.studies.vocabulary import CRITERIA, DEFAULTS, OBJECTIVES, RESPECTS, Criterion, Objective

router = strict_router("/api/v1", "studies")


class Named(TypedDict):
    """A named study or specification, with the comment at the beginning of its text."""

    name: str
    about: Sentences
    definition: dict[str, Any]


class Bounds(TypedDict):
    """A quantity with its limits."""

    name: str
    lowest: Number
    highest: Number
    long_name: str


class Dimension(Bounds):
    """A dimension; `default` is used if a study gives no value for the dimension."""

    default: Number


class AboutVariable(TypedDict):
    """A result variable."""

    name: str
    units: str
    long_name: str
    doc: str
    coded: bool


class SuiteDimension(TypedDict):
    """A dimension of a ground-motion suite."""

    name: str
    units: str
    long_name: str


class OfSuites(TypedDict):
    """Dimensions and variables of ground-motion suites."""

    dimensions: list[SuiteDimension]
    variables: list[AboutVariable]


class Meaning(TypedDict):
    """Name and meaning of a response class."""

    name: str
    sentence: str


class Catalog(TypedDict):
    """Named studies, the parts of a study, and the meaning of results."""

    studies: list[Named]
    specifications: list[Named]
    dimensions: list[Dimension]
    physical: list[Bounds]
    variables: list[AboutVariable]
    suite: OfSuites
    status: dict[str, str]
    response_class: dict[str, Meaning]
    objectives: dict[Objective, str]
    respects: Annotated[dict[str, str], Says(propertyNames={"enum": list(RESPECTS)})]
    tunings: dict[Criterion, str]


@router.get(
    "/catalog",
    response_class=Document,
    responses={200: gives(Catalog)},
    summary="Named studies, dimensions, variables, meanings",
)
def catalog() -> Document:
    """Describe the dimensions of studies and the meaning of results, for a form or a legend."""
    found: Catalog = {
        "studies": [_study(name, text) for name, text in named_texts().items()],
        "specifications": [_study(name, text) for name, text in named_specifications().items()],
        "dimensions": [
            {**_bounds(quantity, DIMENSION_LONG_NAMES[name]), "default": DEFAULTS.get(name)}
            for name, quantity in RATIOS.items()
        ],
        "physical": [_bounds(quantity, quantity.meaning) for quantity in QUANTITIES],
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
    return Document(found)


def _bounds(quantity: Quantity, long_name: str) -> Bounds:
    return {
        "name": quantity.name,
        "lowest": quantity.lowest,
        "highest": quantity.highest,
        "long_name": long_name,
    }


def _variable(variable: Variable) -> AboutVariable:
    return {
        "name": variable.name,
        "units": variable.units,
        "long_name": variable.long_name,
        "doc": variable.doc,
        "coded": variable.flags is not None,
    }


def _study(name: str, text: bytes) -> Named:
    """Read a named study or specification from its text; `about` is the comment at the beginning of the text."""
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
