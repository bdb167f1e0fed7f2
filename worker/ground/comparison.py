"""Dampers beside each other under one record: Table A1, with how much of it is chance."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from damperlab.studies.cavity import cavity_of
from damperlab.studies.ground.motion import GroundMotion
from damperlab.studies.ground.paper import (
    BASE_AMPLITUDES_M,
    CASES,
    CLEARANCES_M,
    SOURCE_NOTE,
    TABLE_A1,
    friction_force_n,
)
from damperlab.studies.ground.question import Earthquake
from damperlab.studies.tmd.absorber import Absorber
from damperlab.studies.tmd.tunings import tuned
from damperlab.studies.vocabulary import Criterion
from damperlab.worker.ground.absorber import absorber_response
from damperlab.worker.ground.design import Damper, Structure, scale_of
from damperlab.worker.ground.response import GroundResponse, Perturbation, Ready, ground_response
from damperlab.worker.scenes import Scene, contact_in
from damperlab.worker.warm import warm

SPREAD = (
    "peak_relative_displacement_m",
    "rms_relative_displacement_m",
    "peak_absolute_displacement_m",
    "rms_absolute_displacement_m",
    "peak_absolute_acceleration_m_s2",
    "rms_absolute_acceleration_m_s2",
)
"""The measures whose spread is reported."""

CHAOTIC = 100.0
"""Growth of a perturbation from which a response is called sensitive: no linear structure grows it by as much."""


def structure_of(asked: Earthquake) -> Structure:
    """The structure of a comparison."""
    values = asked.values
    return Structure(values["mass_kg"], values["natural_frequency_hz"], values["damping_ratio"])


def damper_of(asked: Earthquake, case: str) -> Damper:
    """The damper of one case: friction in fd and hybrid, the particle in pid and hybrid."""
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
    """The tuned mass damper of a comparison; None where neither it nor the particle has a mass."""
    values = asked.values
    mass = values["tmd_mass_kg"]
    mass = values["particle_mass_kg"] if np.isnan(mass) else mass
    if mass == 0.0:
        return None
    return tuned(asked.criterion, mass / values["mass_kg"], values["damping_ratio"])


def scenes_of(asked: Earthquake) -> list[Scene]:
    """Scenes that the cases of a comparison need."""
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


def compare(asked: Earthquake) -> dict[str, Any]:
    """Compute every case of a comparison.

    Returns
    -------
    dict
        ``record`` (its id and summary), ``scale``, ``design``, ``contact``, ``tmd``, and ``cases``: by name the measures of
        `GroundResponse`, ``label`` and, with perturbed starts, ``spread``.
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
        "tmd": None if absorber is None else {"criterion": asked.criterion, **asdict(absorber)},
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
    """Say how far the response depends on what nobody knows: the start, to a given size.

    Parameters
    ----------
    structure, damper, motion, factor, tail_s
        As of `ground_response`.
    nominal : GroundResponse
        The response from rest.
    starts : int
        Perturbed starts: displacement, velocity times 1/ω_n and place of the particle each drawn evenly within ± `size_m`.
    size_m : float
        Size of the perturbation [m].
    seed : int or sequence of int
        Of the draw: the same seed gives the same starts.
    ready : Ready, optional
        As of `ground_response`.

    Returns
    -------
    dict
        For each of `SPREAD` ``lowest``, ``highest``, ``mean``, ``std`` over the starts; ``growth``, the largest change of
        a displacement over `size_m`; ``sensitive``, whether that is beyond `CHAOTIC`.
    """
    draw = np.random.default_rng(seed)
    length = scale_of(structure, motion, factor).length_m
    found: dict[str, list[float]] = {name: [] for name in SPREAD}
    for _ in range(starts):
        v, w, place = draw.uniform(-1.0, 1.0, 3) * size_m
        start = Perturbation(v / length, w / length, place / max(damper.clearance_m, abs(size_m)))
        values = ground_response(structure, damper, motion, factor, tail_s, start, ready).values()
        for name in SPREAD:
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
    change = max(float(np.max(np.abs(np.array(found[name]) - rest[name]))) for name in SPREAD[:4])
    growth = change / size_m if size_m > 0.0 else 0.0
    return {"starts": starts, "size_m": size_m, "growth": growth, "sensitive": growth > CHAOTIC, **answer}


def table_a1(
    motion: GroundMotion,
    factor: float = 1.0,
    tail_s: float = 0.0,
    criterion: Criterion = "den_hartog",
    starts: int = 8,
) -> dict[str, Any]:
    """Recompute Table A1 under one record: for `damperlab check paper`.

    Parameters
    ----------
    motion, factor, tail_s
        The record, what it is multiplied by, and the free vibration after it [s].
    criterion : str
        How the mass damper is tuned; Den Hartog's is the paper's.
    starts : int
        Perturbed starts of each case with a particle.

    Returns
    -------
    dict
        ``rows``: one for each damper of the table and each assumption that was tried, with ``damper``, ``assumption``,
        ``paper_peak_m``, ``paper_rms_m``, ``peak_m``, ``rms_m`` (against the base), ``absolute_peak_m``,
        ``absolute_rms_m``, and the same over no damper: ``paper_peak_share``, ``paper_rms_share``, ``peak_share``,
        ``rms_share``; ``peak_lowest_m`` and ``peak_highest_m`` over the perturbed starts. ``note``: why digits differ.
    """
    structure = Structure()
    none = ground_response(structure, Damper(), motion, factor, tail_s)
    mass = 0.1 * structure.mass_kg
    absorber = tuned(criterion, 0.1, structure.damping_ratio)
    forces = [
        friction_force_n(z, structure.stiffness_n_per_m, structure.damping_ratio) for z in BASE_AMPLITUDES_M
    ]
    rows = [
        _row("none", "", none, none),
        _row("tmd", f"{criterion}, mass ratio 0.1", absorber_response(structure, absorber, motion, factor, tail_s), none),
    ]  # fmt: skip
    tried = [("pid", f"d = {1e3 * d:g} mm", Damper(0.0, mass, d)) for d in CLEARANCES_M]
    tried += [
        ("fd", f"F_f = {force:.3g} N (Z = {1e3 * z:.3g} mm)", Damper(force))
        for z, force in zip(BASE_AMPLITUDES_M, forces, strict=True)
    ]
    tried += [
        ("hybrid", f"d = {1e3 * d:g} mm, F_f = {force:.3g} N", Damper(force, mass, d))
        for d in CLEARANCES_M
        for force in forces
    ]
    for case, assumption, damper in tried:
        response = ground_response(structure, damper, motion, factor, tail_s)
        row = _row(case, assumption, response, none)
        if starts:
            over = spread(structure, damper, motion, response, factor, tail_s, starts)
            peak = over["peak_relative_displacement_m"]
            row |= {"peak_lowest_m": peak["lowest"], "peak_highest_m": peak["highest"]}
            row["sensitive"] = over["sensitive"]
        rows.append(row)
    return {"record": motion.summary(), "factor": factor, "rows": rows, "note": SOURCE_NOTE}


def _row(case: str, assumption: str, response: GroundResponse, none: GroundResponse) -> dict[str, Any]:
    paper, paper_none = TABLE_A1[case], TABLE_A1["none"]
    peak, rms = response.peak_relative_displacement_m, response.rms_relative_displacement_m
    return {
        "damper": case,
        "assumption": assumption,
        "paper_peak_m": paper[0],
        "paper_rms_m": paper[1],
        "peak_m": peak,
        "rms_m": rms,
        "absolute_peak_m": response.peak_absolute_displacement_m,
        "absolute_rms_m": response.rms_absolute_displacement_m,
        "paper_peak_share": paper[0] / paper_none[0],
        "paper_rms_share": paper[1] / paper_none[1],
        "peak_share": peak / none.peak_relative_displacement_m,
        "rms_share": rms / none.rms_relative_displacement_m,
        "energy_residual": response.energy_residual,
        "status": response.status,
    }


def paper_factor(motion: GroundMotion) -> float:
    """Factor on a record that gives the structure without damper the paper's peak, against the base."""
    none = ground_response(Structure(), Damper(), motion)
    return TABLE_A1["none"][0] / none.peak_relative_displacement_m
