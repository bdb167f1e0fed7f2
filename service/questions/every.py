"""All questions about the cube of a study, in the order in which every interface lists the questions."""

from typing import Any

from damperlab.service.questions.fragility import FRAGILITY
from damperlab.service.questions.frequency_response import FREQUENCY_RESPONSE
from damperlab.service.questions.optimal_designs import OPTIMAL_DESIGNS
from damperlab.service.questions.question import Question
from damperlab.service.questions.resonance_map import RESONANCE_MAP
from damperlab.service.questions.tmd_comparison import TMD_COMPARISON
from damperlab.service.questions.work_precision import WORK_PRECISION

EVERY: tuple[Question[Any], ...] = (
    RESONANCE_MAP,
    FREQUENCY_RESPONSE,
    OPTIMAL_DESIGNS,
    TMD_COMPARISON,
    FRAGILITY,
    WORK_PRECISION,
)

BY_ROUTE = {question.route: question for question in EVERY}
