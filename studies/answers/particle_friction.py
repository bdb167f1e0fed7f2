"""Finds the largest particle friction at which a design keeps its promised value, by computing the design with
friction.
"""

from collections.abc import Mapping
from itertools import takewhile
from math import isfinite, nan

import xarray as xr

from damperlab.studies.answers.design_question import FREQUENCY, DesignQuestion
from damperlab.studies.answers.follow_up import follow_up
from damperlab.studies.answers.optimal_designs import optimal_designs
from damperlab.studies.brief import Note
from damperlab.studies.choices import EventSolver
from damperlab.studies.definition import Study
from damperlab.studies.questions import Judging
from damperlab.studies.units import quantities_of
from damperlab.studies.variables import BEFORE, PARTICLE_FRICTION

COEFFICIENTS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5)
"""Examined μ_i, roughly those of a rolling ball, of PTFE, and of dry metals."""
WITHIN = 1.1
"""Allowed multiple of the promised value."""


def study_with_friction(study: Study, question: DesignQuestion, design: Mapping[str, float]) -> Study | None:
    """Make the study that computes one design with friction of its particle.

    Parameters
    ----------
    study : Study
        The study of the design.
    question : DesignQuestion
        The question.
    design : mapping of float
        The design, by dimension; its particle strikes.

    Returns
    -------
    Study or None
        A study over `COEFFICIENTS` and the judged frequencies. None for a study in ratios, if friction or gravity
        already acts on the particle, or if friction cannot be combined with the contact or the solver.
    """
    in_units = {each.source: each.factor for each in quantities_of(study.document())}
    factor = in_units.get(PARTICLE_FRICTION, nan)
    computed = study.contact.model == "instant" and isinstance(study.solver, EventSolver)
    if not computed or not isfinite(factor) or any(name in question.design for name in BEFORE):
        return None
    axes: dict[str, object] = {name: design[name] for name in question.design}
    axes |= {
        FREQUENCY: question.frequencies.tolist(),
        PARTICLE_FRICTION: [each / factor for each in COEFFICIENTS],
    }
    return follow_up(study, axes, "with friction")


def note_of(cube: xr.Dataset, judging: Judging, value: float) -> Note:
    """Note the largest coefficient at which the value rises by at most a tenth of the promise, and the next larger one.

    Parameters
    ----------
    cube : Dataset
        Of `study_with_friction`.
    judging : Judging
        As in `optimal_designs`.
    value : float
        The promised value.
    """
    ranked = optimal_designs(cube, judging, len(COEFFICIENTS))
    kept = {
        float(ratio)
        for ratio, found in zip(ranked[PARTICLE_FRICTION].values, ranked["value"].values, strict=True)
        if found <= WITHIN * value
    }
    ratios = cube[PARTICLE_FRICTION].values.tolist()
    held = len(list(takewhile(kept.__contains__, ratios)))
    fails = COEFFICIENTS[held] if held < len(COEFFICIENTS) else None
    return Note("particle_friction", "hint", {"up_to": (0.0, *COEFFICIENTS)[held], "fails": fails})
