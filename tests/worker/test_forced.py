"""A force on the structure in place of a shaken base: against references that know both, and against what the two share."""

from dataclasses import replace

import numpy as np
import pytest
from tests.reference.simulator import simulate as reference
from tests.worker.forms import night

from damperlab.studies.variables import ResponseClass, Status
from damperlab.worker.point import Design
from damperlab.worker.simulate import simulate
from damperlab.worker.solver.particle import Particle
from damperlab.worker.steady.settle import Settings

# ζ, r, γ_F, (d/Z, e, β), cycles: impacts with friction; chatter with stick; rides without friction; rides and sticks; above
# resonance; friction alone; a mass that friction holds while the particle rests
SCENES = [
    (0.0038, 1.0, 0.4, (5.0, 0.47, 0.1), 12),
    (0.02, 0.9, 0.3, (1.0, 0.6, 0.2), 12),
    (0.02, 0.9, 0.0, (2.0, 0.0, 0.2), 12),
    (0.05, 0.5, 0.2, (0.5, 0.0, 0.3), 12),
    (0.01, 2.0, 0.1, (0.2, 0.3, 0.1), 12),
    (0.0038, 1.02, 0.7, None, 12),
    (0.03, 1.0, 0.95, (0.2, 0.2, 0.4), 10),
]


@pytest.mark.night
@pytest.mark.parametrize("scene", SCENES, ids=str)
def test_a_march_agrees_with_the_reference_simulator(scene) -> None:
    """Rounding of hundreds of events, at most some hundred times 1e-14 of a motion of ten, which impacts amplify."""
    zeta, r, gamma, particle, cycles = scene
    truth = reference(zeta, r, gamma, particle, cycles, digits=30, peaks=True, forced=True)
    design = Design(zeta, r, gamma, Particle(*particle) if particle else None, forced=True)
    found = simulate(design, cycles)
    for name in ("u", "u_rate", "p", "p_rate"):
        if particle is None and name.startswith("p"):
            assert found.state[name] is None
        else:
            assert found.state[name] == pytest.approx(float(truth[name]), rel=0.0, abs=1e-11)
    peaks = np.array([[float(u), float(v)] for u, v in truth["peaks"]])
    assert found.metrics["amplitude_ratio_max"] == pytest.approx(peaks[:, 0].max(), rel=1e-11)
    same = pytest.approx(found.metrics["amplitude_ratio"], rel=1e-12)
    assert found.metrics["relative_amplitude_ratio"] == same
    assert found.events["turns"] == truth["turns"]
    time = 2.0 * np.pi * cycles / r
    assert found.metrics["stick_fraction"] == pytest.approx(float(truth["stuck_time"]) / time, abs=1e-12)
    assert found.metrics["energy_residual"] <= 1e-12


@pytest.mark.parametrize("r", [0.3, 0.97, 1.0, 1.4])
def test_friction_alone_is_the_relative_motion_on_a_shaken_base(r: float) -> None:
    """Both are v'' + 2ζv' + v + γ Sgn v' = P sin rτ, with P = 1 and P = r²; only the start from rest differs."""
    forced = simulate(Design(0.03, r, 0.4, forced=True), followed=False).metrics
    shaken = simulate(Design(0.03, r, 0.4 * r * r), followed=False).metrics
    assert forced["status"] == shaken["status"] == Status.CONVERGED
    apart = 8.0 * (forced["amplitude_error"] + shaken["amplitude_error"] / r**2) + 1e-9
    assert forced["amplitude_ratio"] == pytest.approx(
        shaken["relative_amplitude_ratio"] / r**2, rel=0, abs=apart
    )
    assert forced["stick_fraction"] == pytest.approx(shaken["stick_fraction"], abs=1e-7)
    assert forced["floquet_multiplier"] == pytest.approx(shaken["floquet_multiplier"], abs=1e-6)


def test_the_structure_alone_has_its_closed_form() -> None:
    zeta, r = 0.05, 1.1
    receptance = 1.0 / (1.0 - r * r + 2j * zeta * r)
    found = simulate(Design(zeta, r, forced=True), followed=False)
    assert found.metrics["amplitude_ratio"] == pytest.approx(abs(receptance), rel=1e-14)
    assert found.metrics["relative_amplitude_ratio"] == found.metrics["amplitude_ratio"]
    assert found.state["u"] == pytest.approx(receptance.imag, rel=1e-13)
    assert found.state["u_rate"] == pytest.approx(r * receptance.real, rel=1e-13)
    # the work of the force is what the dashpot takes
    lost = 2.0 * np.pi * zeta * r * abs(receptance) ** 2
    assert found.metrics["dissipation_per_cycle"] == pytest.approx(lost, rel=1e-13)


@pytest.mark.parametrize("energies", [True, night(None)])
def test_friction_as_large_as_the_force_holds_the_mass(energies) -> None:
    """γ_F ≥ 1, so that F_f ≥ F₀: nothing moves, and nothing is divided by the energy of nothing."""
    settings = Settings(4000, 0.02, 1e-9, energies)
    design = Design(0.02, 1.0, 1.0, Particle(5.0, 0.47, 0.1), forced=True)
    found = simulate(design, settings=settings, followed=False).metrics
    assert (found["status"], found["response_class"]) == (Status.CONVERGED, ResponseClass.LOCKED)
    assert found["amplitude_ratio"] == 0.0
    assert found["stick_fraction"] == pytest.approx(1.0, abs=1e-14)
    assert found["energy_residual"] == 0.0 if energies else np.isnan(found["energy_residual"])


def test_fixed_steps_know_a_shaken_base_only() -> None:
    design = replace(Design(0.02, 1.0), forced=True)
    with pytest.raises(ValueError, match="shaken base"):
        simulate(design, 2, method="rk4")
