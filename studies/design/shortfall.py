"""By how much the best damper may be better than the recommended one."""

from math import inf

from damperlab.studies.design.lattice import Candidate
from damperlab.studies.design.search import Search


def shortfall_of(search: Search, best: Candidate) -> float | None:
    """Estimate by how much the best damper of the ranges may stay below the recommended one, in the unit of the measure.

    Beside every candidate that none of its neighbours is better than, the worst case may dip as far as these lie above it;
    the largest of the recommended damper stands against the least of all that. A candidate that was not judged with its
    tolerances is taken to lose the least share by them that any judged one does. None where limits are exceeded: then how
    far, and not the measure, is what dampers are compared by.
    """
    recommended = search.robust[best]
    if recommended.violation > 0.0:
        return None
    scores = search.scores()
    judged = [(scores[each].value, score.value) for each, score in search.robust.items()]
    loss = min((robust / drawn for drawn, robust in judged if 0.0 < drawn < inf), default=1.0)
    lowest = recommended.value
    for each, dip in search.between.dips(scores).items():
        if scores[each].violation == 0.0:
            value = search.robust[each].value if each in search.robust else loss * scores[each].value
            lowest = min(lowest, value - loss * dip)
    return max(recommended.most - max(lowest, 0.0), 0.0)
