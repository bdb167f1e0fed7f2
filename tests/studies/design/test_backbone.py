"""The recommended damper under other amplitudes, against single points of the solver."""

import json
import math

import numpy as np
import pytest
from tests.studies.design.test_design import DAMPED, pursued

from damperlab.studies.design.answer import answer_document
from damperlab.studies.design.backbone import backbone_dataset
from damperlab.worker.point import Design, simulate_ready
from damperlab.worker.solver.particle import Particle

FEW = DAMPED | {"choose": {"friction_force_n": [20.0, 40.0]}, "clearance_m": 0.004, "tolerances": {}}


@pytest.mark.night
def test_the_response_under_every_amplitude_is_that_of_single_points() -> None:
    found, _ = pursued(FEW)
    rows = json.loads(json.dumps(answer_document(found), allow_nan=False))["amplitudes"]
    assert [row["amplitude"] for row in rows] == pytest.approx(np.geomspace(0.0005, 0.002, 7).tolist())
    assert [row["asked"] for row in rows] == [False, False, False, True, False, False, False]
    stiffness = found.asked.structure.stiffness_n_per_m
    for row in (rows[0], rows[-1]):
        z, force = row["amplitude"], found.build.friction_force_n
        assert (row["amplitude_units"], row["units"]) == ("m", "m")
        place = row["value"].index(max(row["value"]))
        assert row["worst"] == row["value"][place] == pytest.approx(z * row["worst_ratio"])
        assert row["worst_frequency_ratio"] == row["frequency_ratio"][place]
        assert row["worst_frequency_hz"] == pytest.approx(8.0 * row["frequency_ratio"][place])
        for at in (0, place):
            r = row["frequency_ratio"][at]
            point = simulate_ready(Design(0.02, r, force / (stiffness * z), Particle(0.004 / z, 0.5, 0.1)))
            # of responses that repeat: the last digits of ratios that are divided in another order
            assert row["ratio"][at] == pytest.approx(float(point.metrics["amplitude_ratio"]), rel=1e-6)
    (told,) = [each for each in answer_document(found)["words"] if each.startswith("Under base amplitudes")]
    assert f"{1e3 * rows[0]['worst']:.4g} mm to {1e3 * rows[-1]['worst']:.4g} mm" in told


def test_amplitudes_are_put_on_the_frequencies_of_all_of_them() -> None:
    def row(amplitude: float, at: list[float], values: list[float | None]) -> dict[str, object]:
        worst = max(each for each in values if each is not None)
        place = values.index(worst)
        return {
            "amplitude": amplitude, "amplitude_units": "m/s", "asked": amplitude < 2.0, "frequency_ratio": at,
            "frequency_hz": [4.0 * each for each in at], "value": values, "ratio": values, "units": "m", "worst": worst,
            "worst_ratio": worst, "worst_frequency_ratio": at[place], "worst_frequency_hz": 4.0 * at[place],
        }  # fmt: skip

    answer = backbone_dataset(
        [row(1.0, [0.5, 1.0], [0.1, 0.2]), row(2.0, [0.5, 0.75, 1.0], [0.3, None, 0.4])]
    )
    assert answer["frequency_ratio"].values.tolist() == [0.5, 0.75, 1.0]
    assert answer["frequency_hz"].values.tolist() == [2.0, 3.0, 4.0]
    assert answer["value"].sel(amplitude=2.0, frequency_ratio=1.0) == 0.4
    assert answer["value"].sel(amplitude=1.0, frequency_ratio=1.0) == 0.2
    nothing = answer["value"].sel(frequency_ratio=0.75).values.tolist()
    assert all(math.isnan(each) for each in nothing)
    assert answer["worst"].values.tolist() == [0.2, 0.4]
    assert answer["asked"].values.tolist() == [True, False]
    assert answer["amplitude"].attrs["units"] == "m/s"
    assert backbone_dataset([]).sizes == {"amplitude": 0, "frequency_ratio": 0}
