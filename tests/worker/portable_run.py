"""Computes what must have the same bits on every processor, and prints hashes; run by `test_portable` for two of them."""

import hashlib
from collections.abc import Iterator

import numpy as np
from tests.synthetic_history import made_history

from damperlab.studies.definition import parse_harmonic
from damperlab.studies.fit.asking import make_question
from damperlab.studies.fit.fitted import Estimate
from damperlab.studies.fit.measured import Measurement
from damperlab.studies.ground.kanai_tajimi import kanai_tajimi
from damperlab.studies.ground.random_vibration import RandomVibration
from damperlab.studies.ground.shock import Shock
from damperlab.studies.ground.sweep import Sweep
from damperlab.studies.plan import Block
from damperlab.worker.block import solve_block
from damperlab.worker.fit.estimate import fit_response
from damperlab.worker.fit.history.estimate import fit_history
from damperlab.worker.fit.model import responses_at


def of(*arrays: np.ndarray) -> str:
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()[:16]


def of_estimates(estimates: tuple[Estimate, ...]) -> str:
    return of(np.array([[each.value, each.low, each.high, each.spread] for each in estimates]))


def records() -> Iterator[tuple[str, str]]:
    for order in range(3):
        for logarithmic in (False, True):
            sweep = Sweep(1.3, 7.1, 31.0, logarithmic, 0.7, order, 2.0)
            yield f"sweep {order} {logarithmic}", sweep.motion().sha256
    yield "random vibration", RandomVibration((1.3, 7.1, 31.0), (2.0, 0.3, 0.7), 3.0, 7).motion().sha256
    yield "shock", Shock("half_sine", 3.0, 11.0, 0.1).motion().sha256
    yield "record of a spectrum", kanai_tajimi(seed=3).sha256


def closed_forms() -> Iterator[tuple[str, str]]:
    axes = {
        "frequency_ratio": np.linspace(0.3, 3.0, 271).tolist(),
        "mass_ratio": 0.0,
        "friction_ratio": 0.0,
    }
    for excitation in ("base", "force"):
        document = {"axes": axes, "damping_ratio": 0.02, "particle": False, "excitation": excitation}
        study = parse_harmonic(document)
        block = solve_block(study, Block.whole(study.shape))
        yield f"linear, {excitation}", of(*(block[name] for name in sorted(block) if name != "run_time"))


def fits() -> Iterator[tuple[str, str]]:
    columns = {"frequency_ratio": np.linspace(0.9, 1.1, 15)}
    structure = {"particle": False}
    sought = {"friction_ratio": (0.0, 0.7), "damping_ratio": (0.003, 0.3)}
    blank = make_question(Measurement("", columns | {"amplitude_ratio": np.ones(15)}), structure, sought)
    true = responses_at(blank, {"friction_ratio": 0.35, "damping_ratio": 0.02}).amplitude
    noise = np.random.default_rng(5).standard_normal(15)
    measured = Measurement("", columns | {"amplitude_ratio": true * (1.0 + 0.03 * noise)})
    fitted = fit_response(make_question(measured, structure, sought))
    yield "fit of a response", of_estimates(fitted.estimates)
    yield "its correlations", of(fitted.correlation)
    history = fit_history(made_history("friction", 1).question)
    yield "fit of a time history", of_estimates(history.estimates)


if __name__ == "__main__":
    for name, bits in (*records(), *closed_forms(), *fits()):
        print(f"{name}: {bits}")
