"""A question that the cube cannot answer as it was put."""

from damperlab.studies.faults import Fault


class QueryFault(ValueError):
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
