"""Small mistakes put into a copy of the sources, each of which a named test must find: what shows that tests are sharp.

A mutant that outlives its test is a defect of the test; one whose text is not there any more is renewed or taken out.
"""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import psutil

ROOT = Path(__file__).parent.parent
SECONDS = 600.0
"""Longer than any of these tests needs, however loaded the machine: it ends one that hangs, which counts as found."""


class Mutant(NamedTuple):
    """One mistake: a text of a file, what stands there instead, and the test that must fail then."""

    file: str
    text: str
    instead: str
    test: str


MUTANTS = (
    Mutant("worker/run/lease.py", "RENEW_SECONDS = 5.0", "RENEW_SECONDS = 90.0", "tests/test_times.py"),
    Mutant("service/security/guard.py", "KEPT_SECONDS = 5.0", "KEPT_SECONDS = 5000.0", "tests/test_times.py"),
    Mutant("studies/fit/fitted.py", "OUTLIER / rows", "OUTLIER", "tests/studies/fit/test_fitted.py"),
    Mutant(
        "service/page/fit.js",
        """units.amplitude !== "m" ? 1 : 1000""",
        """units.amplitude !== "m" ? 1 : 100""",
        "tests/service/page/test_page_browser.py::test_a_fit_and_an_earthquake_need_no_study",
    ),
    Mutant(
        "studies/store/files/folder.py",
        "        sync_path(self._path.parent)\n",
        "",
        "tests/studies/store/test_folder.py",
    ),
    Mutant(
        "studies/ground/random_vibration.py",
        "(np.arange(1, length // 2 + 1) - 0.5)",
        "np.arange(1, length // 2 + 1)",
        "tests/studies/ground/test_random_vibration.py",
    ),
    Mutant(
        "studies/fit/asking.py",
        "settings, share, confidence, seed)",
        "settings, share, 0.9, seed)",
        "tests/worker/fit/test_estimate.py::test_the_linear_structure_gives_its_damping_back_with_the_error_of_least_squares",
    ),
    Mutant(
        "worker/kernel_cache.py",
        "return (head, kernel) if whole else None",
        "return (head, kernel)",
        "tests/worker/test_kernel_cache.py::test_a_damaged_kernel_counts_as_none",
    ),
    Mutant(
        "worker/fingerprint.py",
        "            yield from _value(function.__globals__[name], seen)\n",
        "",
        "tests/worker/test_kernel_cache.py::test_a_function_is_known_by_its_code_and_by_the_values_that_it_takes",
    ),
    Mutant(
        "studies/answers/largest_acceleration.py",
        " + acting.friction_ratio\n",
        "\n",
        "tests/worker/test_acceleration.py::test_the_largest_acceleration_is_that_where_the_structure_turns",
    ),
    Mutant(
        "worker/steady/stopping_rules.py",
        "        and mean.stationary\n",
        "",
        "tests/worker/steady/test_stopping_rules.py",
    ),
    Mutant(
        "service/design_run.py",
        "if self.kept.round is None:",
        "if False:",
        "tests/service/test_design_run.py",
    ),
    Mutant(
        "service/security/sessions.py",
        "        self._open.pop(_hashed(value), None)\n",
        "",
        "tests/service/security/test_who_may_ask.py::test_a_session_ends_on_the_server",
    ),
    Mutant(
        "service/work/processes.py",
        """["type"] != "http.disconnect":""",
        """["type"] != "http.disconnected":""",
        "tests/service/security/test_work_apart.py::test_what_a_study_is_asked_ends_with_its_client",
    ),
    Mutant(
        "service/work/later.py",
        "        promise.given_up.set()\n        self._promises.pop",
        "        self._promises.pop",
        "tests/service/security/test_promised_answers.py::test_what_is_given_up_is_computed_no_longer",
    ),
    Mutant(
        "service/client/transport.py",
        "                self._http.delete(where)\n",
        "                pass\n",
        "tests/service/security/test_promised_answers.py::test_the_client_of_python_gives_up_what_it_no_longer_waits_for",
    ),
    Mutant(
        "service/page/design.js",
        """metres: units === "m" ? 1000 : 1""",
        "metres: 1",
        "tests/service/page/test_page_browser.py::test_a_design_is_asked_for_in_the_form_followed_and_answered",
    ),
    Mutant(
        "service/page/numbers.js", "seconds / 60,", "seconds / 600,", "tests/service/page/test_page_files.py"
    ),
    Mutant(
        "worker/run/background.py",
        "            self._work()\n        except BaseException",
        "            self._work()\n        except StoreFault",
        "tests/worker/run/test_background.py",
    ),
    Mutant(
        "service/page/headline.js",
        "OF_EVERY_DESIGN.includes(kind) || !(next || clamps || few)",
        'kind !== "hidden_peak"',
        "tests/service/page/test_first_look_browser.py",
    ),
    Mutant(
        "studies/ground/shelf.py",
        "            sync_path(self.folder.parent)\n",
        "",
        "tests/studies/store/test_folder.py",
    ),
    Mutant(
        "studies/store/files/folder.py",
        "            sync_path(target.parent)\n",
        "            pass\n",
        "tests/studies/store/test_folder.py",
    ),
    Mutant(
        "service/security/sessions.py",
        "return key_id if ends > time.time() else None",
        "return key_id or None",
        "tests/service/security/test_who_may_ask.py::test_a_session_ends_after_hours_and_with_its_key",
    ),
    Mutant(
        "service/simulation_request.py",
        'if method == "rk4" and isinstance(contact, DwellContact | CompliantContact):',
        'if method == "rk4" and isinstance(contact, DwellContact):',
        "tests/service/cli/test_cli_refused.py",
    ),
    Mutant(
        "service/page/numbers.js",
        "short(1000 * value,",
        "short(value,",
        "tests/service/page/test_page_files.py",
    ),
    Mutant(
        "studies/answers/fragility.py",
        "DROP = 1.9207",
        "DROP = 1.3528",
        "tests/studies/answers/test_fragility.py",
    ),
    Mutant(
        "worker/dispatch/workers.py",
        "self.retries += attempt.tries > 0",
        "self.retries += attempt.tries",
        "tests/worker/dispatch/test_workers.py",
    ),
    Mutant(
        "worker/dispatch/workers.py",
        "if not leaves and self._is_alone(worker):",
        "if self._is_alone(worker):",
        "tests/worker/dispatch/test_workers.py",
    ),
    Mutant(
        "studies/design/space.py",
        "(1, -1, -1, -1, -1, 1, 1)",
        "(1, -1, -1, -1, -1, 1, -1)",
        "tests/studies/design/test_parts.py::test_corners_are_all_of_a_few_tolerances_and_a_fraction_of_many",
    ),
)


def is_found(mutant: Mutant, copy: Path) -> bool:
    """Put a mistake into a copy, run its test, and mend the copy again; whether the test failed."""
    file = copy / mutant.file
    right = file.read_text()
    if right.count(mutant.text) != 1:
        raise ValueError(
            f"{mutant.file} holds {mutant.text!r} {right.count(mutant.text)} times, and must once"
        )
    file.write_text(right.replace(mutant.text, mutant.instead))
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", mutant.test]
    sources = str(copy / "src")
    environment = os.environ | {"PYTHONPATH": sources, "PYTHONDONTWRITEBYTECODE": "1"}
    try:
        with subprocess.Popen(command, cwd=copy, env=environment) as process:
            try:
                return process.wait(SECONDS) == 1
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGINT)  # killed, it would leave its services behind
                return True
    finally:
        file.write_text(right)
        end_what_is_left(sources)


def end_what_is_left(sources: str) -> None:
    """End the processes that a failed test leaves: what a mutant does not give up would be computed for hours."""
    for process in psutil.process_iter(["environ"]):
        if (process.info["environ"] or {}).get("PYTHONPATH") == sources:
            process.kill()


def main() -> None:
    """Try every mutant, and fail with the names of those that outlived their test."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "copy"
        listed = ["git", "ls-files", "-z"]
        files = subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split(
            "\0"
        )
        for name in filter(None, files):
            (copy / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, copy / name, follow_symlinks=False)
        left = [mutant for mutant in MUTANTS if not is_found(mutant, copy)]
    for mutant in left:
        print(f"{mutant.test} passes although {mutant.file} has {mutant.instead!r} for {mutant.text!r}")
    print(f"{len(MUTANTS) - len(left)} of {len(MUTANTS)} mutants were found")
    sys.exit(bool(left))


if __name__ == "__main__":
    main()
