"""Compares dampers under one record, and measures how sensitive the responses are to the start."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from damperlab.studies.cavity import cavity_of
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.question import Earthquake
from damperlab.studies.tmd.absorber import Absorber
from damperlab.studies.tmd.tunings import tuned
from damperlab.studies.tmd.under_record import MEASURES
from damperlab.studies.vocabulary import CASES
from damperlab.worker.ground.absorber import absorber_response
from damperlab.worker.ground.compared import Comparison
from damperlab.worker.ground.design import Damper, Structure, scale_of
from damperlab.worker.ground.measures import GroundResponse
from damperlab.worker.ground.response import Perturbation, Ready, ground_response
from damperlab.worker.scenes import Scene, contact_in
from damperlab.worker.warm import warm

CHAOTIC = 100.0
"""Growth of a perturbation above which a response is called sensitive. Linear structures do not reach this growth."""


def structure_of(asked: Earthquake) -> Structure:
    """Return the structure of a comparison."""
    values = asked.values
    return Structure(values["mass_kg"], values["natural_frequency_hz"], values["damping_ratio"])


def damper_of(asked: Earthquake, case: str) -> Damper:
    """Return the damper in one case: fd and hybrid have friction, pid and hybrid have a particle."""
    values = asked.values
    return Damper(
        values["friction_force_n"] if case in ("fd", "hybrid") else 0.0,
        values["particle_mass_kg"] if case in ("pid", "hybrid") else 0.0,
        values["clearance_m"],
        values["restitution"],
        asked.contact,
        cavity_of(values),
    )


def absorber_of(asked: Earthquake) -> Absorber | None:
    """Return the tuned mass damper, or None if its mass is 0. The default mass is the mass of the particle."""
    values = asked.values
    mass = values["tmd_mass_kg"]
    mass = values["particle_mass_kg"] if np.isnan(mass) else mass
    if mass == 0.0:
        return None
    return tuned(asked.criterion, mass / values["mass_kg"], values["damping_ratio"])


def scenes_of(asked: Earthquake) -> list[Scene]:
    """Return the scenes that are needed for a comparison."""
    dampers = [damper_of(asked, case) for case in asked.cases if case != "tmd"]
    return sorted(
        {
            Scene(
                "record",
                d.friction_force_n > 0.0,
                contact_in(d.cavity, d.contact) if d.particle_mass_kg > 0.0 else "",
            )
            for d in dampers
        }
    )


def compare(asked: Earthquake) -> Comparison:
    """Compute all cases of a comparison.

    Returns
    -------
    Comparison
        Result. Each of the ``cases`` has the measures of `GroundResponse`, a ``label`` and, with perturbed starts, a
        ``spread``.
    """
    structure = structure_of(asked)
    absorber = absorber_of(asked)
    factor, tail = asked.values["scale"], asked.values["tail_s"]
    cases: dict[str, Any] = {}
    for scene in scenes_of(asked):
        warm(scene)
    for case in asked.cases:
        if case == "tmd":
            response = absorber_response(structure, absorber, asked.motion, factor, tail)
            cases[case] = {"label": CASES[case], **response.values()}
            continue
        damper = damper_of(asked, case)
        response = ground_response(structure, damper, asked.motion, factor, tail)
        cases[case] = {"label": CASES[case], **response.values()}
        if asked.starts and case != "none":
            size = asked.values["perturbation_m"]
            cases[case]["spread"] = spread(
                structure, damper, asked.motion, response, factor, tail, asked.starts, size, asked.seed
            )
    if cavity_of(asked.values).particle_friction_coefficient:
        for each in cases.values():
            each.setdefault("loss_particle_j", 0.0)
    values = {name: value for name, value in asked.values.items() if not np.isnan(value)}
    return {
        "record": {"id": asked.record_id, **asked.motion.summary()},
        "length_scale_m": scale_of(structure, asked.motion, factor).length_m,
        "design": values,
        "contact": asked.contact.model_dump(mode="json"),
        "tmd": None
        if absorber is None
        else {
            "criterion": asked.criterion,
            "mass_ratio": absorber.mass_ratio,
            "tuning": absorber.tuning,
            "damping_ratio": absorber.damping_ratio,
        },
        "cases": cases,
    }


def spread(
    structure: Structure,
    damper: Damper,
    motion: GroundMotion,
    nominal: GroundResponse,
    factor: float = 1.0,
    tail_s: float = 0.0,
    starts: int = 16,
    size_m: float = 1e-7,
    seed: int | Sequence[int] = 0,
    ready: Ready | None = None,
) -> dict[str, Any]:
    """Compute the sensitivity of a response to perturbations of the start.

    Parameters
    ----------
    structure, damper, motion, factor, tail_s
        Arguments as in `ground_response`.
    nominal : GroundResponse
        Response from rest.
    starts : int
        Number of perturbed starts. Displacement, velocity over ω_n and position of the particle are drawn uniformly
        within ± `size_m`.
    size_m : float
        Size of the perturbation [m].
    seed : int or sequence of int
        Seed for drawing the starts.
    ready : Ready, optional
        Argument as in `ground_response`.

    Returns
    -------
    dict
        Statistics ``lowest``, ``highest``, ``mean`` and ``std`` over the starts for each of `MEASURES`. ``growth`` is the
        largest change of a displacement divided by `size_m`, and ``sensitive`` states whether it exceeds `CHAOTIC`.
    """
    draw = np.random.default_rng(seed)
    length = scale_of(structure, motion, factor).length_m
    found: dict[str, list[float]] = {name: [] for name in MEASURES}
    for _ in range(starts):
        v, w, place = draw.uniform(-1.0, 1.0, 3) * size_m
        start = Perturbation(v / length, w / length, place / max(damper.clearance_m, abs(size_m)))
        values = ground_response(structure, damper, motion, factor, tail_s, start, ready).values()
        for name in MEASURES:
            found[name].append(float(values[name]))
    answer: dict[str, Any] = {
        name: {
            "lowest": float(np.min(column)),
            "highest": float(np.max(column)),
            "mean": float(np.mean(column)),
            "std": float(np.std(column, ddof=1)) if starts > 1 else 0.0,
        }
        for name, column in found.items()
    }
    rest = nominal.values()
    moved = [name for name in MEASURES if name.endswith("displacement_m")]
    change = max(float(np.max(np.abs(np.array(found[name]) - rest[name]))) for name in moved)
    growth = change / size_m if size_m > 0.0 else 0.0
    return {"starts": starts, "size_m": size_m, "growth": growth, "sensitive": growth > CHAOTIC, **answer}
