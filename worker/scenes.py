"""Scenes: combinations of forces and a requested result, for which kernels are compiled."""

from typing import Literal, NamedTuple

import numpy as np

from damperlab.studies.cavity import Cavity
from damperlab.studies.choices import Contact, Rk4Solver
from damperlab.studies.definition import Study
from damperlab.studies.ground.suite import Suite
from damperlab.studies.kind import AnyStudy
from damperlab.studies.variables import GRAVITY, MADE_BY, PARTICLE_FRICTION
from damperlab.studies.vocabulary import CONTACT_MODELS
from damperlab.worker.solver.particle import FALLING, RUBBING, Particle

Purpose = Literal[
    "steady",
    "peaks",
    "acceleration",
    "orbit",
    "transient",
    "record",
    "record-history",
    "accuracy",
    "stepped",
    "rk4",
]
"""Requested result of a scene.

`steady`, `peaks` and `acceleration` are a steady response with energies, without energies, and with energies and
acceleration; `orbit` is one cycle for display. `transient` is a measured motion from rest. `record` is a response to a
record, and `record-history` also its time history. `accuracy` is an integration for the accuracy report. `stepped` is a
steady response and `rk4` a motion from rest, both with fixed steps.
"""

_STEADY: tuple[Purpose, ...] = ("steady", "peaks", "acceleration")

SECONDS: dict[Purpose, float] = {
    "steady": 20.0,
    "peaks": 18.0,
    "acceleration": 21.0,
    "orbit": 8.0,
    "transient": 10.0,
    "record": 12.0,
    "record-history": 12.0,
    "accuracy": 20.0,
    "stepped": 4.0,
    "rk4": 3.0,
}
"""Approximate CPU time [s] of compilation for each result, with friction and with instantaneous contact."""
CONTACT_FACTOR = {"": 0.6, "instant": 1.0, "dwell": 1.1, "compliant": 2.2, RUBBING: 1.6, FALLING: 1.7}
"""Compile time for each contact, relative to instantaneous contact."""


class Scene(NamedTuple):
    """A combination of forces and a requested result, for which kernels are compiled.

    Parameters
    ----------
    purpose : str
        Requested result.
    friction : bool
        Whether friction acts.
    contact : str
        Contact model of the particle, `RUBBING` or `FALLING`; empty without a particle.
    """

    purpose: Purpose
    friction: bool
    contact: str = ""

    @property
    def name(self) -> str:
        """Name of the scene in file names and on the command line."""
        parts = [
            self.purpose,
            "friction" if self.friction else "",
            self.contact and f"particle-{self.contact}",
        ]
        return "-".join(filter(None, parts)) if any(parts[1:]) else f"{self.purpose}-linear"

    @property
    def seconds(self) -> float:
        """Approximate compile time [CPU s]."""
        return SECONDS[self.purpose] * CONTACT_FACTOR[self.contact]


SPECTRUM = Scene("record", False, "")
"""Scene for response spectra: a structure without a damper under a record."""


def every_scene() -> list[Scene]:
    """Return all scenes in descending order of compile time."""
    acting = [(True, ""), *((friction, contact) for friction in (True, False) for contact in CONTACT_MODELS)]
    found = [Scene(purpose, *what) for purpose in _STEADY for what in acting]
    others: tuple[Purpose, ...] = ("orbit", "transient", "record", "record-history")
    found += [Scene(purpose, *what) for purpose in others for what in (*acting, (False, ""))]
    rubbing: tuple[Purpose, ...] = (*_STEADY, *others)
    found += [
        Scene(purpose, f, acts) for purpose in rubbing for f in (True, False) for acts in (RUBBING, FALLING)
    ]
    stepped = [what for what in (*acting, (False, "")) if what[1] in ("", "instant")]
    found += [Scene(purpose, *what) for purpose in ("stepped", "rk4") for what in stepped]
    found += [Scene("accuracy", *what) for what in (*acting, (False, ""))]
    return sorted(found, key=lambda scene: -scene.seconds)


def accuracy_scenes() -> list[Scene]:
    """Return the scenes for the accuracy report in descending order of compile time."""
    needed = ("accuracy", "steady", "transient", "rk4")
    return [one for one in every_scene() if one.purpose in needed]


def usual_scenes() -> list[Scene]:
    """Return the scenes for default studies, designs, points and earthquakes, in descending order of compile time."""
    purposes = ("steady", "peaks", "orbit", "transient", "record")
    return [one for one in every_scene() if one.purpose in purposes and one.contact in ("", "instant")]


def scene_named(name: str) -> Scene:
    """Return the scene with a given name, or raise KeyError."""
    return {scene.name: scene for scene in every_scene()}[name]


def scenes(study: AnyStudy) -> list[Scene]:
    """Return the scenes for the blocks of a study. The list is empty if every point has a closed form."""
    if isinstance(study, Suite):
        forces, masses = (
            _signs(study.coordinates[name]) for name in ("friction_force_n", "particle_mass_kg")
        )
        acts = contact_in(study.cavity, study.contact)
        return sorted(Scene("record", f, acts if p else "") for f in forces for p in masses)
    if not isinstance(study, Study):
        raise TypeError(f"there are no kernels for a {type(study).__name__}")
    from damperlab.worker.kernel_arguments import wants_acceleration, wants_energies  # imports the compiler

    rubs = _signs(study.coordinates["friction_force_n" if study.over_amplitudes else "friction_ratio"])
    rattles = {p and study.particle for p in _signs(study.coordinates["mass_ratio"])}
    if isinstance(study.solver, Rk4Solver):
        return sorted(Scene("stepped", f, "instant" if p else "") for f in rubs for p in rattles)
    purpose: Purpose = "steady" if wants_energies(study) else "peaks"
    if wants_acceleration(study):
        purpose = "acceleration"
    drags, falls = (_acting(study, name) for name in (PARTICLE_FRICTION, GRAVITY))
    contacts = {FALLING if f else RUBBING if d else study.contact.model for d in drags for f in falls}
    return sorted(
        Scene(purpose, f, contact)
        for f in rubs
        for p in rattles
        for contact in (contacts if p else ("",))
        if f or p
    )


def _acting(study: Study, ratio: str) -> set[bool]:
    """Return {True} if a force of `BEFORE` acts at all points, {False} if at no point, and {False, True} otherwise."""
    if study.over_amplitudes and study.physical is not None:
        return _signs(study.physical.values().get(MADE_BY[ratio], np.zeros(1)))
    return _signs(study.coordinates.get(ratio, np.zeros(1)))


def _signs(values: np.ndarray) -> set[bool]:
    """Return {True} if all values (in ascending order) are above 0, {False} if none is, and {False, True} otherwise."""
    return {bool(value > 0.0) for value in values[[0, -1]]}


def contact_in(cavity: Cavity, contact: Contact) -> str:
    """Return the name of the contact model for a contact in a cavity."""
    if not cavity.acts:
        return contact.model
    return FALLING if cavity.tilt_deg > 0.0 else RUBBING


def contact_name(particle: Particle | None) -> str:
    """Return the name of the contact model for a particle; empty without a particle."""
    if particle is None:
        return ""
    if particle.gravity is not None:
        return FALLING
    if particle.friction is not None:
        return RUBBING
    return "compliant" if particle.wall else "dwell" if particle.contact_time is not None else "instant"
