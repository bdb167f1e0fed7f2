"""What the tests of the page ask it, again and again."""

import gc
import time
import warnings
from collections.abc import Callable
from typing import Any

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page, Route, expect

KNOWN_POINTS = """() => {
  const plot = document.querySelector(".plot");
  return plot?.data?.[0]?.customdata?.flat().filter((value) => value !== null).length ?? -1;
}"""
"""How many points of the first map have a value; -1 before there is one."""
TRACES = """(label) => [...document.querySelectorAll(".plot")]
  .find((plot) => plot.getAttribute("aria-label") === label)
  ?.data?.map(({ name, x, y }) => ({ name, x: [...x], y: [...y] })) ?? []"""
"""What the figure of a label draws."""
NO_PLOT_IS_EMPTY = "() => !document.querySelector('.plot:empty')"
ONE_STEP = 1200
"""Milliseconds after which a change of the address is a step of its own."""

IN_UNITS: dict[str, Any] = {
    "name": "damper in units",
    "damping_ratio": 0.02,
    "physical": {
        "mass_kg": 1.605, "natural_frequency_hz": 2.5, "base_amplitude_m": 0.0015, "particle_mass_kg": 0.1605,
        "clearance_m": [0.006, 0.012], "friction_force_n": [0.06, 0.12], "excitation_frequency_hz": [2.25, 2.5, 2.75],
    },
    "axes": {"restitution": 0.47},
}  # fmt: skip
"""A hybrid damper."""


def until(
    page: Page, question: str, good: Callable[[Any], bool], given: object = None, seconds: float = 600.0
) -> Any:
    """Ask the page until the answer is good; its policy forbids what `wait_for_function` does."""
    give_up = time.monotonic() + seconds
    while not good(answer := page.evaluate(question, given)):
        assert time.monotonic() < give_up, (answer, page.locator(".fault").all_text_contents())
        page.wait_for_timeout(100)
    return answer


def pick(page: Page, label: str, value: str) -> None:
    """Choose in the list beside a label."""
    field = page.locator("label.field").filter(has=page.get_by_text(label, exact=True))
    field.locator("select").select_option(value)


def one_step(page: Page, change: Callable[[], object]) -> None:
    """Change what the address keeps, and wait until the next change is a step of its own."""
    before = page.url
    change()
    expect(page).not_to_have_url(before)
    page.wait_for_timeout(ONE_STEP)


def serious(page: Page, schemes: tuple[str, ...] = ("light", "dark")) -> list[Any]:
    """What axe finds that is serious or critical."""
    bad: list[Any] = []
    for scheme in schemes:
        page.emulate_media(color_scheme=scheme)  # type: ignore[arg-type]
        page.wait_for_timeout(100)
        found = Axe().run(page).response["violations"]
        bad += [
            (scheme, one["id"], [node["html"][:200] for node in one["nodes"]])
            for one in found
            if one["impact"] in ("serious", "critical")
        ]
    return bad


def run_the_lines_of_python(page: Page, within: str = "") -> list[Any]:
    """Run every line of Python that figures of the page give, each once, and give what they come to."""
    lines = set(page.locator(f"{within} .figure details pre").all_text_contents()) - {""}
    found = []
    with warnings.catch_warnings():
        # a line that somebody pastes closes no client
        warnings.simplefilter("ignore", ResourceWarning)
        for line in lines:
            names: dict[str, Any] = {}
            imported, _, call = line.rpartition("\n\n")
            exec(imported, names)
            found.append(eval(call, names))
        gc.collect()
    return found


class Held:
    """A request that waits until it is let go: the first with `part` in its address; all others pass."""

    def __init__(self, page: Page, part: str) -> None:
        self.page, self.part = page, part
        self.waiting: list[Route] = []
        page.route("**/api/v1/**", self.hold)

    def hold(self, route: Route) -> None:
        if self.part in route.request.url and not self.waiting:
            self.waiting.append(route)
        else:
            route.continue_()

    def wait(self) -> Route:
        """Wait until it was asked."""
        for _ in range(6000):
            if self.waiting:
                return self.waiting[0]
            self.page.wait_for_timeout(50)
        raise AssertionError(f"nothing with {self.part} was asked for")

    def let_go(self) -> None:
        route = self.wait()
        with self.page.expect_response(route.request.url):
            route.continue_()
        self.page.wait_for_timeout(300)
