"""Designs beside brute force: ``python -m tests.benchmarks.design [SPECIFICATIONS]`` prints a line for each.

``python -m tests.benchmarks.design builds SEED [LIMIT]`` holds the stated probability alone against 1,000 builds.

Each specification is a seeded draw of a structure, a band and ranges of clearance and friction force. Brute force is a
grid of 21 × 21 dampers at 121 frequencies, computed by the solver, and 9 × 9 dampers closer together about its best and
about the recommended one; what may be the least is computed at 961 frequencies, since 121 miss the top of a peak. Then the
response found is made a limit, the tolerances are drawn 1,000 times, and the share of builds that keep it is held
against the stated interval.
"""

import sys
from typing import Any

import numpy as np
from tests.studies.design.test_design import pursued, solved

from damperlab.studies.definition import parse_study
from damperlab.studies.design.book import Book
from damperlab.studies.design.found import Found
from damperlab.studies.design.search import Search
from damperlab.studies.design.steps import in_studies
from damperlab.studies.specification.reading import parse_specification

SIDE, FREQUENCIES = 21, 121
FINE = 961
"""Frequencies; those of the grid are among them."""
STAGES = (61, 121, 241, 481)
"""Frequencies at which a build is looked at, one after the other, until it is seen to exceed the limit."""
LOCAL, REACH = 9, 1 / 32
"""Dampers to a side about a damper, and how far to either side, as a share of the ranges."""
BUILDS = 1000
BUDGET = 100_000
LIMIT = 1.06
"""Of the response as drawn: a limit that some builds keep and others do not."""
TOLERANCES = {"clearance_m": 0.05, "friction_force_n": 0.1}
_taken: list[int] = []
"""Points of every grid that was computed."""


def drawn(seed: int) -> dict[str, Any]:
    """Draw a specification with two quantities to choose."""
    rng = np.random.default_rng(seed)
    mass, frequency = 10 ** rng.uniform(0, 3), 10 ** rng.uniform(0, 1.5)
    amplitude = 10 ** rng.uniform(-4, -2.5)
    force = mass * (2 * np.pi * frequency) ** 2 * amplitude
    least = rng.uniform(1, 3) * amplitude
    return {
        "name": f"drawn {seed}",
        "structure": {
            "mass_kg": mass,
            "natural_frequency_hz": frequency,
            "damping_ratio": rng.uniform(0.003, 0.03),
        },
        "excitation": {
            "base_amplitude_m": amplitude,
            "frequency_hz": {
                "start": rng.uniform(0.8, 0.95) * frequency,
                "stop": rng.uniform(1.05, 1.25) * frequency,
            },
        },
        "choose": {
            "clearance_m": {"start": least, "stop": least + rng.uniform(5, 15) * amplitude},
            "friction_force_n": {"start": 0.0, "stop": rng.uniform(0.3, 0.7) * force},
        },
        "particle_mass_kg": rng.uniform(0.03, 0.2) * mass,
        "restitution": rng.uniform(0.2, 0.8),
        "builds": 60,
    }


def peaks(
    document: dict[str, Any], clearances_m: np.ndarray, forces_n: np.ndarray, frequencies: int
) -> np.ndarray:
    """Largest displacement [m] over the band of every damper of a grid, clearances by forces."""
    structure, excitation = document["structure"], document["excitation"]
    amplitude, band = excitation["base_amplitude_m"], excitation["frequency_hz"]
    own = structure["natural_frequency_hz"]
    stiffness = structure["mass_kg"] * (2 * np.pi * own) ** 2
    study = parse_study(
        {
            "damping_ratio": structure["damping_ratio"],
            "axes": {
                "clearance_ratio": (clearances_m / amplitude).tolist(),
                "friction_ratio": (forces_n / (stiffness * amplitude)).tolist(),
                "restitution": document["restitution"],
                "mass_ratio": document["particle_mass_kg"] / structure["mass_kg"],
                "frequency_ratio": {
                    "start": band["start"] / own,
                    "stop": band["stop"] / own,
                    "num": frequencies,
                },
            },
            "metrics": ["amplitude_ratio"],
        }
    )
    _taken.append(study.points)
    ratios = solved(study)["amplitude_ratio"].max("frequency_ratio").values
    return amplitude * ratios.reshape(clearances_m.size, forces_n.size)


def compare(seed: int, builds: int = BUILDS) -> dict[str, Any]:
    """Compare one drawn specification with brute force."""
    document = drawn(seed)
    found, _ = pursued(document, BUDGET)
    _taken.clear()
    ranges = document["choose"]
    clearances = np.linspace(ranges["clearance_m"]["start"], ranges["clearance_m"]["stop"], SIDE)
    forces = np.linspace(0.0, ranges["friction_force_n"]["stop"], SIDE)
    build = found.build
    coarse = peaks(document, clearances, forces, FREQUENCIES)
    best, at = least(document, clearances, forces, coarse)
    for clearance, force in {at, (build.clearance_m, build.friction_force_n)}:
        best = min(best, _about(document, clearance, force))
    by_brute_force = sum(_taken)
    fine = peaks(document, np.array([build.clearance_m]), np.array([build.friction_force_n]), FINE).item()
    row = {
        "seed": seed,
        "found": found.nominal.value,
        "error": found.nominal.error,
        "brute force": float(best),
        "found over brute force": found.nominal.value / best,
        "true over stated": fine / found.nominal.most,
        "points of the search": searched(document),
        "points of the whole answer": found.book.spent,
        "points of brute force": by_brute_force,
    }
    return row | _probability(document, found, builds)


def searched(document: dict[str, Any]) -> int:
    """Count the points that the search alone takes: without other dampers, masses, amplitudes and starts beside its answer."""
    asked = parse_specification(document)
    search = Search(asked, Book(asked, BUDGET))
    for studies in in_studies(search.book, search.run()):
        search.book.add(map(solved, studies))
    return search.book.spent


def least(
    document: dict[str, Any], clearances_m: np.ndarray, forces_n: np.ndarray, coarse: np.ndarray
) -> tuple[float, tuple[float, float]]:
    """Least peak of a grid at `FINE` frequencies, and whose; a peak can only grow as more of them are known."""
    best, at = np.inf, (np.nan, np.nan)
    for place in np.argsort(coarse.ravel()):
        i, j = divmod(int(place), forces_n.size)
        if coarse[i, j] >= best:
            break
        fine = peaks(document, clearances_m[[i]], forces_n[[j]], FINE).item()
        if fine < best:
            best, at = fine, (float(clearances_m[i]), float(forces_n[j]))
    return best, at


def _about(document: dict[str, Any], clearance_m: float, force_n: float) -> float:
    """Least peak of dampers close to one."""
    axes: list[np.ndarray] = []
    for name, centre in (("clearance_m", clearance_m), ("friction_force_n", force_n)):
        low, high = (document["choose"][name][end] for end in ("start", "stop"))
        near = centre + (high - low) * REACH * np.linspace(-1.0, 1.0, LOCAL)
        axes.append(np.unique(np.clip(near, low, high)))
    clearances, forces = axes
    return least(document, clearances, forces, peaks(document, clearances, forces, 2 * FREQUENCIES - 1))[0]


def _probability(document: dict[str, Any], found: Found, builds: int, over: float = LIMIT) -> dict[str, Any]:
    """Hold the stated interval against the share of many builds that keep a limit, so many times the response found."""
    limited = document | {
        "limits": {"displacement_m": over * found.nominal.value},
        "tolerances": {name: f"{100 * share:g}%" for name, share in TOLERANCES.items()},
    }
    answer, _ = pursued(limited, BUDGET)
    rng = np.random.default_rng(1)
    kept = 0
    for _ in range(builds):
        shares = 1 + np.array(list(TOLERANCES.values())) * rng.uniform(-1, 1, 2)
        one = (
            np.array([answer.build.clearance_m]) * shares[0],
            np.array([answer.build.friction_force_n]) * shares[1],
        )
        limit = limited["limits"]["displacement_m"]
        kept += all(peaks(document, *one, stage).item() <= limit for stage in STAGES)
    assert answer.builds is not None
    return {"probability": [answer.builds.low, answer.builds.high], "share of many": kept / builds}


def main() -> None:
    """Print the rows."""
    if sys.argv[1:2] == ["builds"]:
        document = drawn(int(sys.argv[2]))
        found, _ = pursued(document, BUDGET)
        over = float(sys.argv[3]) if len(sys.argv) > 3 else LIMIT
        print(_probability(document, found, BUILDS, over))
        return
    for seed in range(int(sys.argv[1]) if len(sys.argv) > 1 else 5):
        row = compare(seed)
        print("; ".join(f"{name} {_spelled(value)}" for name, value in row.items()), flush=True)


def _spelled(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    main()
