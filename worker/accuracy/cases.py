"""Scenes for the comparison of methods, and their final states in extended precision."""

import json
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

from damperlab.worker.physics.compliant_wall import wall_constants
from damperlab.worker.point import Design
from damperlab.worker.solver.particle import Particle, Wall

State = tuple[float, float, float, float]
"""u, u', p, p' in absolute coordinates, relative to Z and Z·ω_n. Without a particle, p = p' = 0."""


@dataclass(frozen=True)
class Scene:
    """A design point that is integrated from rest over a number of excitation cycles.

    Parameters
    ----------
    name, title : str
        Short name, and title in the report.
    design : Design
        The design point.
    cycles : int
        Number of cycles after which the final state is compared.
    """

    name: str
    title: str
    design: Design
    cycles: int


_STIFF = Wall(*wall_constants(0.47, 1e-3, 0.1))

SCENES: tuple[Scene, ...] = (
    Scene("linear", "structure alone", Design(0.0038, 1.0), 10),
    Scene("friction", "friction", Design(0.0038, 1.0, 0.6), 10),
    Scene("particle", "particle", Design(0.0038, 1.0, 0.0, Particle(10.0, 0.47, 0.1)), 10),
    Scene("hybrid", "friction and particle", Design(0.0038, 1.0, 0.4, Particle(5.0, 0.47, 0.1)), 10),
    Scene(
        "hybrid-stick",
        "friction and particle, with stick",
        Design(0.0038, 0.9, 0.6, Particle(2.0, 0.47, 0.1)),
        10,
    ),
    Scene("chatter", "chatter and attachment", Design(0.0038, 0.9, 0.6, Particle(0.5, 0.1, 0.1)), 10),
    Scene(
        "compliant",
        f"friction and particle, walls of {_STIFF.stiffness:.2g} k",
        Design(0.0038, 1.0, 0.4, Particle(2.0, 0.47, 0.1, None, _STIFF)),
        4,
    ),
)


@dataclass(frozen=True)
class Reference:
    """The final state of a scene, stored with 25 digits and rounded to doubles.

    Parameters
    ----------
    state : tuple of float
        Final values of u, u', p, p'.
    amplification : float
        Ratio of a change of the final state to a small change of the initial state. Rounding of the inputs
        can change the final state by 1e-16 times this ratio.
    """

    state: State
    amplification: float


@cache
def references() -> dict[str, Reference]:
    """Read the reference of each scene from `references.json`.

    The entry `how` of `references.json` explains how the references were computed.
    """
    document = json.loads(
        (files("damperlab.worker.accuracy") / "references.json").read_text(encoding="utf-8")
    )
    return {
        name: Reference(tuple(float(digits) for digits in one["state"].values()), one["amplification"])  # type: ignore[arg-type]
        for name, one in document["scenes"].items()
    }
