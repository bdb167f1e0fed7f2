"""Read a time history from a table of text. Every fault states the line."""

import numpy as np

from damperlab.studies.equal_steps import TOO_FEW_DIGITS, equal_step, resolution_of, wrong_step
from damperlab.studies.faults import Fault, StudyFaults, counted, printable
from damperlab.studies.fit.columns import (
    PERCENT,
    SHARES,
    Column,
    faults_of_comments,
    read_headings,
    says_time,
)
from damperlab.studies.fit.history.question import History
from damperlab.studies.fit.lines import LARGEST, Lines, check_lines, columns_of, lines_of
from damperlab.studies.portable import acos, cos
from damperlab.studies.spelled_numbers import fault_of_marks, read_decimal
from damperlab.studies.written_units import ACCELERATIONS, LENGTHS, TIMES

LEAST_ROWS, MOST_ROWS = 24, 20_000
HELD, RESTING = 0.8, 0.2
"""Lower limit for a held structure, and upper limit for a structure at rest, as shares of the largest displacement."""
BEYOND, LONGER, AT_ONCE_RAD = -0.3, 1.3, 0.2
"""A structure counts as held if the displacement stays above `HELD` for more than `LONGER` times the duration
of the fall to `BEYOND`. A release within the phase `AT_ONCE_RAD` after the first row counts as a release in
the first row.
"""
FALL, WINDOW = (0.8, 0.3), 5
"""The release is located from the samples in which the displacement falls from the first to the second value
of `FALL`, as shares of the largest displacement. The position before the release is fitted to at most
`WINDOW` times as many samples as this fall has.
"""

TIME, DISPLACEMENT, RELATIVE, BASE = "time_s", "displacement_m", "relative_displacement_m", "base_m_s2"
DEVIATION = "deviation_m"
OF_HISTORY = (
    "An impact changes the velocity almost instantly: an accelerometer records a pulse whose height and "
    "shape depend on the sensor and its filter",
    "integrate the recorded acceleration twice, with a zero-phase high-pass filter well below the natural "
    "frequency. Give the result as `displacement (mm)`, with the first row at rest or at the release. "
    "For the base, use `base acceleration (m/s2)`",
)
"""The reason why an acceleration of the structure over time is not fitted, and the remedy."""
COLUMNS = (
    Column({TIME: TIMES}, ("time", "t")),
    Column({DISPLACEMENT: LENGTHS}, ("displacement", "absolute displacement", "x")),
    Column({RELATIVE: LENGTHS}, ("relative displacement", "x-z", "x - z")),
    Column({BASE: ACCELERATIONS}, ("base acceleration", "ground acceleration")),
    Column({DEVIATION: LENGTHS, PERCENT: SHARES}, ("deviation", "standard deviation")),
)
"""Every column of a time history."""


def is_history(lines: Lines) -> bool:
    """Return whether a table has a column of times, and is therefore a time history."""
    return any(says_time(cell) for cell in lines.cells(lines.heading[1]))


def parse_history(text: bytes | str, name: str = "history") -> History:
    """Read a time history.

    Parameters
    ----------
    text : bytes or str
        A table whose first line names the columns with their units. ``time (s)`` has equal steps. The second column is
        ``displacement (mm)`` of the structure, or ``relative displacement (mm)`` to the base. If the base moves,
        ``base acceleration (m/s2)`` is needed. The standard deviation may be given as ``deviation (mm)``, or as
        ``deviation (%)`` of the largest displacement.
    name : str
        Name of the measurement.

    Raises
    ------
    StudyFaults
        If the table is invalid. The exception contains all faults.
    """
    lines = lines_of(text)
    names, factors = _headings(lines)
    columns = _numbers(lines, names, factors)
    at = names.index(TIME)
    written = [lines.cells(line)[at] for _, line in lines.rows]
    numbers = [number for number, _ in lines.rows]
    marks = (
        fault_of_marks((columns[each] / by).round(6).tolist(), numbers)
        for each, by in zip(names, factors, strict=True)
    )
    faults = [fault for fault in marks if fault]
    if faults:
        raise StudyFaults(faults)
    step = _step(columns[TIME], factors[at] * resolution_of(written), numbers, faults)
    moved = columns[RELATIVE if RELATIVE in columns else DISPLACEMENT]
    release = _released(moved) if BASE not in columns and moved.any() else 0
    faults += _of_start(moved, columns.get(BASE), release)
    if faults:
        raise StudyFaults(faults)
    before = release or 0
    moved = moved[before:]
    columns = {column: numbers[before:] for column, numbers in columns.items()}
    deviation = columns.get(DEVIATION)
    if PERCENT in columns:
        deviation = columns[PERCENT] * np.abs(moved).max()
    relative = RELATIVE in columns or BASE not in columns
    return History(name, step, moved, relative, columns.get(BASE), deviation, before)


def _headings(lines: Lines) -> tuple[list[str], list[float]]:
    number, text = lines.heading
    names, factors, faults = read_headings(lines.cells(text), number, COLUMNS, OF_HISTORY)
    if not faults:
        moved = {DISPLACEMENT, RELATIVE} & set(names)
        if len(moved) != 1:
            found = "both" if moved else "neither"
            told = "A time history must have one column of displacement, absolute or relative to the base."
            advice = "remove one of the two" if moved else "add a column such as `displacement (mm)`"
            allowed = f"one of {DISPLACEMENT} and {RELATIVE}"
            faults.append(Fault(f"line {number}", found, allowed, advice, told))
        faults += faults_of_comments(lines.comments, lines.cells(text))
    if faults:
        raise StudyFaults(faults)
    return names, factors


def _numbers(lines: Lines, names: list[str], factors: list[float]) -> dict[str, np.ndarray]:
    if not LEAST_ROWS <= len(lines.rows) <= MOST_ROWS:
        found = counted(len(lines.rows), "row")
        allowed = f"from {LEAST_ROWS} to {MOST_ROWS:,} rows"
        told = f"The time history has {found}; it must have {allowed}."
        advice = "measure longer" if len(lines.rows) < LEAST_ROWS else "leave samples out, or cut the end"
        raise StudyFaults([Fault("measured", found, allowed, advice, told)])
    check_lines(lines, len(names))
    of = dict(zip(names, factors, strict=True))
    return columns_of(lines, names, lambda name, cell: _cell(name, of[name], cell), [])


def _cell(name: str, factor: float, cell: str) -> float | Fault:
    """Read one number and convert it to SI units."""
    value = read_decimal(cell)
    positive = name in (DEVIATION, PERCENT)
    if not abs(value) <= LARGEST or (positive and value <= 0.0):
        allowed = "a number above 0" if positive else "a number"
        found = printable(cell) if cell else "an empty cell"
        return Fault(name, found, allowed, "correct the cell", f"{{field}} must be {allowed}, not {found}.")
    return value * factor


def _step(time: np.ndarray, resolution: float, numbers: list[int], faults: list[Fault]) -> float:
    """Return the time step, and record a fault if the steps are not equal."""
    step, wrong = equal_step(time, resolution)
    if wrong is not None:
        told, advice = wrong_step(numbers[wrong], time[wrong - 1], time[wrong], step)
        faults.append(Fault(TIME, f"{time[wrong]:g} s in line {numbers[wrong]}", "equal steps", advice, told))
    elif np.isnan(step):
        advice = "write the times with more digits"
        faults.append(Fault(TIME, f"times such as {time[-1]:g} s", "equal steps", advice, TOO_FEW_DIGITS))
    return step


def _released(moved: np.ndarray) -> int | None:
    """Return the row of the release, or None if the structure oscillates before the largest displacement.

    The release is the row for which a constant before it and a cosine after it fit the samples best.
    """
    share = moved / np.abs(moved).max()
    first = int(np.argmax(np.abs(share) >= HELD))
    share *= np.sign(share[first])
    end = first + int(np.argmax(share[first:] < FALL[1]))
    away = max(first, end - int(np.argmax(share[first:end][::-1] >= FALL[0]))) if end > first else first
    begin, fall = max(first, away - WINDOW * (end - away)), np.arange(away, end)
    if not first < away < end:
        return None if first else 0
    found = []
    for row in range(max(begin, 2 * away - end - 1), away):
        held = share[begin : row + 1].mean()
        rate = float(np.mean(acos(np.minimum(share[fall] / held, 1.0)) / (fall - row)))
        after = share[row + 1 : end] - held * cos(rate * np.arange(1, end - row))
        found.append((float(np.sum((share[begin : row + 1] - held) ** 2) + np.sum(after**2)), row, rate))
    _, row, rate = min(found)
    if first == 0:
        return row if row > 1 and row * rate > AT_ONCE_RAD else 0
    beyond = first + int(np.argmax(share[first:] < BEYOND))
    return row if away - first > LONGER * (beyond - away) + 2.0 else None


def _of_start(moved: np.ndarray, base: np.ndarray | None, release: int | None) -> list[Fault]:
    """Find faults in the first displacement, in the free decay and in the motion of the base."""
    largest = float(np.abs(moved).max())
    first = abs(float(moved[0]))
    field = DISPLACEMENT
    if largest == 0.0:
        return [Fault(field, "0 throughout", "a structure that moves", "check the column and its unit")]
    share = f"a first displacement of {100 * first / largest:.3g} % of the largest"
    if release is None:
        told = "Without a base acceleration the history must begin at a release from rest, or while the structure is held."
        told += f" This history has {share}, and oscillates before the largest displacement."
        advice = "hold the structure aside for half a period, or add the column `base acceleration (m/s2)`"
        return [Fault(field, share, f"at least {100 * HELD:g} %", advice, told)]
    if moved.size - release < LEAST_ROWS:
        found = f"{counted(moved.size - release, 'row')} from the release in row {release + 1} on"
        told, allowed = f"The time history has {found}.", f"at least {LEAST_ROWS} rows"
        return [Fault("measured", found, allowed, "measure longer", told)]
    decay = moved[release:]
    crossings = np.flatnonzero(np.diff(np.sign(decay)))
    last = np.abs(decay[crossings[-1] + 1 :] if crossings.size else decay)
    turned = np.minimum(np.maximum.accumulate(last), np.maximum.accumulate(last[::-1])[::-1]) - last
    if base is None and turned.max() > RESTING * np.ptp(decay) / 2.0:
        told = "The structure swings about another position than 0, but its rest position must be 0."
        advice = "subtract the position in which it comes to rest"
        return [Fault(field, "a swing that does not cross 0", "a decay about 0", advice, told)]
    if base is not None and not np.abs(base).max() > 0.0:
        told = "The base acceleration is 0 throughout."
        return [Fault(BASE, "0", "a base that moves", "leave the column out of a free decay", told)]
    if base is not None and first > RESTING * largest:
        told = f"A history with a base acceleration must begin at rest; this history has {share}."
        advice = "begin the table where the base begins to move"
        return [Fault(field, share, f"at most {100 * RESTING:g} %", advice, told)]
    return []
