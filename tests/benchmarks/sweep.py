"""Random design points over the legal ranges: each ends, and none has a NaN with a good status."""

from collections import Counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damperlab.studies.choices import CompliantContact, Contact, DwellContact
from damperlab.studies.consistency import LEAST_COMPLIANT
from damperlab.studies.variables import DIMENSIONS, VARIABLES, Status
from damperlab.worker.kernel_arguments import contact_time_of, rebound_of, wall_of
from damperlab.worker.solver.particle import Particle
from damperlab.worker.steady.response.closed_form import linear_response
from damperlab.worker.steady.settle import Settings, at_rest, settle

POINTS = 1_000_000
CYCLES = 60
RESIDUAL = 1e-9
"""Largest share of the energy that may be unaccounted for."""
SETTINGS = Settings(CYCLES, 0.02, 1e-9)
CONTACTS = ("instant", "dwell", "compliant")
# of some responses there is no multiplier; accelerations are not asked for
NEED_NOT_BE_FINITE = ("floquet_multiplier", "run_time", "acceleration_ratio", "acceleration_ratio_rms")


def random_points(count: int, seed: int) -> dict[str, NDArray[np.float64]]:
    """Points log-uniform where a range spans decades, with special values and ties among them.

    Returns
    -------
    dict of ndarray, shape (count,)
        The six dimensions; `particle`: 1 with one, 0 without; `contact`: index into `CONTACTS`; `contact_time`; and
        `forced`: 1 under a force on the structure, 0 on a shaken base.
    """
    random = np.random.default_rng(seed)

    def mixed(values: NDArray[np.float64], specials: list[Any], share: float = 0.25) -> NDArray[np.float64]:
        chosen = random.integers(0, len(specials), count)
        table = np.stack([np.broadcast_to(np.asarray(one, float), (count,)) for one in specials])
        return np.where(random.random(count) < share, table[chosen, np.arange(count)], values)

    def spread(low: float, high: float) -> NDArray[np.float64]:
        return np.asarray(np.exp(random.uniform(np.log(low), np.log(high), count)))

    def either(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.where(random.random(count) < 0.5, one, other)

    damping = mixed(either(spread(1e-6, 0.99), random.uniform(0.0, 0.99, count)), [0.0, 0.0038, 0.5, 0.99])
    frequency = mixed(either(spread(0.01, 100.0), spread(0.5, 2.0)), [1.0, 0.01, 0.5, 1.0 / 3.0, 2.0, 100.0])
    mass = mixed(either(spread(1e-9, 10.0), random.uniform(0.0, 10.0, count)), [0.0, 0.1, 1.0, 10.0])
    restitution = mixed(random.uniform(0.0, 1.0, count), [0.0, 1.0, 0.47, 0.82, 1.0 - 1e-12])
    with np.errstate(divide="ignore"):
        alone = 1.0 / np.hypot(1.0 - frequency**2, 2.0 * damping)
    clearance = mixed(spread(0.01, 1000.0), [1.0, 0.01, 1000.0, 2.0, alone])
    square = frequency**2
    ties = [0.0, np.pi / 4.0, 1.0, 2.0, square, square * (1.0 + mass), np.pi / 4.0 + 1e-9]
    friction = np.minimum(mixed(random.uniform(0.0, 2.0, count), ties, 0.4), 1e6)
    values = (damping, restitution, mass, np.clip(clearance, 0.01, 1000.0), friction, frequency)
    return dict(zip(DIMENSIONS, values, strict=True)) | {
        "particle": (random.random(count) < 0.85).astype(float),
        "contact": random.choice(len(CONTACTS), count, p=(0.6, 0.2, 0.2)).astype(float),
        "contact_time": spread(1e-6, 10.0),
        "forced": (random.random(count) < 0.3).astype(float),
    }


def particle_of(point: dict[str, float]) -> Particle | None:
    """Particle of a point as a block would make it; None without one."""
    if not point["particle"] or point["mass_ratio"] == 0.0:
        return None
    restitution, mass = point["restitution"], point["mass_ratio"]
    contact: Contact | None = None
    if CONTACTS[int(point["contact"])] == "dwell":
        contact = DwellContact(model="dwell", contact_time=point["contact_time"])
    elif CONTACTS[int(point["contact"])] == "compliant":
        restitution = max(restitution, LEAST_COMPLIANT)
        contact = CompliantContact(model="compliant", contact_time=point["contact_time"])
    return Particle(
        point["clearance_ratio"],
        rebound_of(restitution),
        mass,
        contact_time_of(contact),
        wall_of(contact, restitution, mass),
    )


def solve(point: dict[str, float]) -> dict[str, Any]:
    """Every variable of one point, by the kernel of its scene, as a block would compute it."""
    friction = point["friction_ratio"] if point["friction_ratio"] > 0.0 else None
    particle = particle_of(point)
    r = point["frequency_ratio"]
    if friction is None and particle is None:
        closed = linear_response(np.array([point["damping_ratio"]]), np.array([r]), bool(point["forced"]))
        return {name: column[0] for name, column in closed.items()}
    forced = bool(point["forced"])
    rest = at_rest(r, friction, particle, forced)
    found, _ = settle(point["damping_ratio"], r, friction, particle, SETTINGS, rest, forced)
    return dict(found._asdict())


def fault_of(values: dict[str, Any], forced: bool = False) -> str | None:
    """What is wrong with the values of one point, None if nothing is."""
    if values["status"] not in {int(one) for one in Status} or values["status"] == Status.NOT_COMPUTED:
        return f"status {values['status']}"
    if values["status"] > Status.MAX_CYCLES:
        return None
    for name, value in values.items():
        error_of_few = name == "amplitude_error" and values["status"] == Status.MAX_CYCLES
        if (
            name in VARIABLES
            and name not in NEED_NOT_BE_FINITE
            and not error_of_few
            and not np.isfinite(value)
        ):
            return f"{name} = {value} with status {values['status']}"
    apart = abs(values["amplitude_ratio"] - values["relative_amplitude_ratio"])
    # of a mass that hardly moves the place where friction holds it, about 1, has the digits
    if forced and apart > 1e-9 * values["amplitude_ratio"] + 1e-14:
        return f"amplitude_ratio = {values['amplitude_ratio']}, but the base rests"
    if values["energy_residual"] > RESIDUAL:
        return f"energy residual {values['energy_residual']:.1e}"
    shares = ("stick_fraction", "dissipation_viscous", "dissipation_friction", "dissipation_impact")
    for name in shares:
        if not -1e-12 <= values[name] <= 1.0 + 1e-12:
            return f"{name} = {values[name]}"
    return None


def sweep(count: int, seed: int = 0) -> dict[str, Any]:
    """Solve random points.

    Returns
    -------
    dict
        `found`: faulty points, each with what is `wrong`; `status`: points by status.
    """
    columns = {name: column.tolist() for name, column in random_points(count, seed).items()}
    states: Counter[int] = Counter()
    found: list[dict[str, Any]] = []
    for i in range(count):
        point = {name: column[i] for name, column in columns.items()}
        values = solve(point)
        states[int(values["status"])] += 1
        wrong = fault_of(values, forced=bool(point["forced"]))
        if wrong is not None:
            found.append({"wrong": wrong, **point})
    return {"found": found, "status": {Status(code).name: number for code, number in states.items()}}


def run() -> dict[str, Any]:
    """A million points."""
    return sweep(POINTS)
