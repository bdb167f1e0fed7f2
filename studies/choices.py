"""Settings of a study besides the axes: contact, steady state, solver and start."""

from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Tag,
)

from damperlab.studies.faults import (
    NOTHING,
    Fault,
    StudyFaults,
    describe,
    path,
    unknown_key,
    write_nearest,
)
from damperlab.studies.presets import CONTACT_TIMES
from damperlab.studies.quantity import Quantity, read_count
from damperlab.studies.reads import Reads
from damperlab.studies.vocabulary import CONTACT_MODELS, EXCITATIONS, METHODS, START_KINDS


def real(quantity: Quantity) -> Reads:
    """Return the pydantic annotation of a number within bounds."""
    bounds = {"type": "number", "minimum": quantity.lowest, "maximum": quantity.highest}
    return Reads(quantity.read, bounds | {"description": quantity.meaning})


def whole(lowest: int, highest: int, meaning: str) -> Reads:
    """Return the pydantic annotation of a whole number within bounds."""
    bounds = {"type": "integer", "minimum": lowest, "maximum": highest, "description": meaning}
    return Reads(lambda raw: read_count(raw, lowest, highest), bounds)


CONTACT_TIME = Quantity(
    "contact_time", "contact time, in units of 1/ω_n", 1e-9, 1e3,
    "give the time in units of 1/ω_n",
)  # fmt: skip


def _read_contact_time(raw: object) -> float:
    """Read a contact time, which is a number or a name in `CONTACT_TIMES`."""
    if isinstance(raw, str) and raw in CONTACT_TIMES:
        return CONTACT_TIMES[raw].contact_time
    if isinstance(raw, str):
        allowed = f"{CONTACT_TIME.allowed}, or one of {', '.join(CONTACT_TIMES)}"
        raise StudyFaults([Fault("", describe(raw), allowed, "write a number, or one of these names")])
    return CONTACT_TIME.read(raw)


def _contact_time() -> Reads:
    """Return the pydantic annotation of a contact time, which is a number or a name."""
    number = {"type": "number", "minimum": CONTACT_TIME.lowest, "maximum": CONTACT_TIME.highest}
    named = {"type": "string", "enum": list(CONTACT_TIMES)}
    return Reads(_read_contact_time, {"anyOf": [number, named], "description": CONTACT_TIME.meaning})


# A standard error falls as N^-½ with the number N of cycles.
# Two periods of a periodic response differ by rounding errors of about 1e-14.
TOLERANCE = Quantity(
    "tolerance", "relative standard error at which the mean of a modulated response is accepted", 1e-8, 0.5,
    "the default is 0.02, one standard error of 2 %; the cycles needed grow as its inverse square",
)  # fmt: skip
PERIODIC_TOLERANCE = Quantity(
    "periodic_tolerance", "relative distance from periodicity at which a response counts as periodic",
    1e-13, 1e-2,
    "the default is 1e-9; differences below 1e-13 are rounding errors",
)  # fmt: skip


class Choice(BaseModel):
    """Base class of the pydantic models in a study. Instances are immutable, and unknown keys are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid")


def read_excitation(raw: object) -> Literal["force"] | None:
    """Read the excitation of the structure. Return None for a shaken base, which is the default."""
    if raw is None or raw == "base":
        return None
    if raw == "force":
        return "force"
    raise StudyFaults([Fault("", describe(raw), " or ".join(EXCITATIONS), write_nearest(raw, EXCITATIONS))])


ExcitationField = Annotated[
    Literal["force"] | None,
    Reads(
        read_excitation,
        {
            "type": ["string", "null"],
            "enum": [*EXCITATIONS, None],
            "description": "what excites the structure: its base (the default), or a force F₀ sin ωt on it. "
            "Under a force the base stands still, and the static displacement F₀/k replaces the base "
            "amplitude in every ratio",
        },
    ),
]


class InstantContact(Choice):
    """Instantaneous impacts by the rebound law, equations (7) and (8) of the paper."""

    model: Literal["instant"] = "instant"


class DwellContact(Choice):
    """The particle moves with the wall for a contact time, then leaves with e times its approach speed."""

    model: Literal["dwell"]
    contact_time: Annotated[float, _contact_time()]


class CompliantContact(Choice):
    """The wall is a spring and a dashpot that push but never pull.

    An impact in free space lasts this contact time, and has the coefficient of restitution e of the study. As the
    contact time tends to 0, this model tends to `instant`. e must not be 0, because e = 0 would require infinite
    damping.
    """

    model: Literal["compliant"]
    contact_time: Annotated[float, _contact_time()]


class Steady(Choice):
    """Criteria for accepting the response of a design point as steady."""

    max_cycles: Annotated[int, whole(1, 1_000_000, "excitation cycles after which a point stops")] = 4000
    tolerance: Annotated[float, real(TOLERANCE)] = 0.02
    periodic_tolerance: Annotated[float, real(PERIODIC_TOLERANCE)] = 1e-9


class EventSolver(Choice):
    """The solver that is exact between events."""

    method: Literal["event"] = "event"


class Rk4Solver(Choice):
    """The paper's method, for comparison: the classical Runge-Kutta method with a fixed step. Impacts are detected at
    the ends of steps.
    """

    method: Literal["rk4"]
    steps_per_cycle: Annotated[int, whole(20, 1_000_000, "steps per excitation cycle")] = 400


class Ensemble(Choice):
    """Start from rest and from `n` − 1 random states, and store the most frequent response.

    The random states depend only on the seed and on the coordinates of the design point; see
    `damperlab.worker.steady.ensemble`.
    """

    kind: Literal["ensemble"]
    n: Annotated[int, whole(1, 10_000, "start states of each design point, the first at rest")]
    seed: Annotated[int, whole(0, 2**32 - 1, "seed of the start states")] = 0


class Continuation(Choice):
    """Start each frequency from the final state of the response at the previous frequency. The frequencies rise (`up`)
    or fall (`down`), and the first frequency starts from rest.
    """

    kind: Literal["continuation"]
    direction: Literal["up", "down"] = "up"


def _choice(
    key: str, tags: tuple[str, ...], settings: tuple[str, ...] = ()
) -> tuple[Discriminator, BeforeValidator]:
    """Return the two annotations that select one of several pydantic models by the text under `key`.

    The first of `tags` is the default. Without `settings`, every choice is written as a mapping. With
    `settings`, the default is written as a name, and any other choice as a mapping with keys in `settings`.
    """
    plain = bool(settings)

    def name(raw: Any) -> Any:
        if isinstance(raw, dict):
            return raw.get(key, None if plain else tags[0])
        return getattr(raw, key, raw)

    def check(raw: Any) -> Any:
        if plain and raw == {key: tags[0]}:
            return tags[0]  # the default may also be written as a mapping
        written = isinstance(raw, dict | BaseModel) or (plain and isinstance(raw, str))
        if not written:
            allowed = tags[0] if plain else f"a mapping, such as {{{key}: {tags[0]}}}"
            raise StudyFaults([Fault("", describe(raw), allowed, "write it in that form")])
        if plain and isinstance(raw, dict) and key not in raw:
            raise StudyFaults(_without_key(raw, key, tags[1:], settings))
        chosen = name(raw)
        if isinstance(raw, str) and chosen in tags[1:]:
            allowed = f"{tags[0]}, or a mapping such as {{{key}: {chosen}}}"
            raise StudyFaults([Fault("", describe(raw), allowed, "write it as a mapping, with its settings")])
        where = key if isinstance(raw, dict | BaseModel) else ""
        if chosen not in tags:
            allowed = " or ".join(tags)
            raise StudyFaults([Fault(where, describe(chosen), allowed, write_nearest(chosen, tags))])
        return raw

    return Discriminator(name), BeforeValidator(check)


def _without_key(
    raw: dict[Any, Any], key: str, tags: tuple[str, ...], settings: tuple[str, ...]
) -> list[Fault]:
    """Return the faults of a mapping without `key`: the missing key, and all unknown keys."""
    meant = next((tag for tag in tags if tag in raw), None)
    advice = f"write `{key}: {meant}`, with its settings beside it" if meant else f"add `{key}`"
    unknown = [one for one in raw if one not in settings]
    return [
        Fault(key, NOTHING, " or ".join(tags), advice),
        *(unknown_key(path([one]), one, (key, *settings), raw) for one in unknown),
    ]


Contact = Annotated[
    Annotated[InstantContact, Tag("instant")]
    | Annotated[DwellContact, Tag("dwell")]
    | Annotated[CompliantContact, Tag("compliant")],
    *_choice("model", tuple(CONTACT_MODELS)),
]
Solver = Annotated[
    Annotated[EventSolver, Tag("event")] | Annotated[Rk4Solver, Tag("rk4")],
    *_choice("method", METHODS),
]
Start = Annotated[
    Annotated[Literal["rest"], Tag("rest")]
    | Annotated[Ensemble, Tag("ensemble")]
    | Annotated[Continuation, Tag("continuation")],
    *_choice("kind", tuple(START_KINDS), settings=("n", "seed", "direction")),
]
