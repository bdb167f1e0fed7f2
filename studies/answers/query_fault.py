"""A question that the cube cannot answer as it was put."""

import numpy as np

from damperlab.studies.faults import Fault, counted
from damperlab.studies.user_error import UserError

NONE_QUALIFIES = "No design of the study qualifies, so there is none to start from."


class QueryFault(UserError, ValueError):
    """What is wrong with the question, and what may be asked instead.

    Parameters
    ----------
    fault : Fault
        Which argument, what was found, what is allowed, what to do.
    """

    def __init__(self, fault: Fault) -> None:
        super().__init__(str(fault))
        self.fault = fault

    def __reduce__(self) -> tuple[type["QueryFault"], tuple[Fault]]:
        """Pickle by the fault, so that it travels between processes whole."""
        return type(self), (self.fault,)


def refused(field: str, found: str, allowed: str, advice: str, told: str = "") -> QueryFault:
    """Refuse a question for one argument; `told` is the sentence, where the usual one does not say it."""
    return QueryFault(Fault(field, found, allowed, advice, told))


def empty_range(field: str, name: str, low: float, high: float, values: np.ndarray) -> Fault:
    """Make the fault for a range from `low` to `high` that contains none of the `values` of the dimension `name`."""
    least, most = f"{values.min():.10g}", f"{values.max():.10g}"
    held = f"{counted(values.size, 'value')} from {least} to {most}" if values.size > 1 else f"only {least}"
    near = values[np.abs(values - low).argmin()]
    return Fault(
        field,
        f"{low:.10g} to {high:.10g}",
        f"a range that contains a value of {name}",
        f"widen it; the nearest value is {near:.10g}",
        f"The range of {name} from {low:.10g} to {high:.10g} contains none of its values; the study has {held}.",
    )
