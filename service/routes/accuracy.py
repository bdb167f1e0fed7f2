"""Routes of the last accuracy report."""

from damperlab.service.answer_types import gives
from damperlab.service.documents import Document
from damperlab.service.problems import Problem, documented
from damperlab.service.reports import AccuracyReport, AccuracyReports, last_report
from damperlab.service.routes.strict import strict_router
from damperlab.service.state import TheService

router = strict_router("/api/v1", "accuracy")


@router.get(
    "/accuracy/reports",
    response_class=Document,
    responses={200: gives(AccuracyReports)},
    summary="The available accuracy reports",
)
def list_reports(service: TheService) -> Document:
    """List the time and version of the latest report in this data directory. Without a report the list is empty."""
    report = last_report(service.settings.data_dir)
    told = ("created", "version", "passed")
    kept = [] if report is None else [{name: report[name] for name in told if name in report}]
    return Document({"reports": kept})


@router.get(
    "/accuracy",
    response_class=Document,
    responses={200: gives(AccuracyReport), **documented(404)},
    summary="Error against run time, and extreme cases, as last measured",
)
def ask_accuracy(service: TheService) -> Document:
    """Give the latest report that `damperlab check accuracy` has written into this data directory."""
    report = last_report(service.settings.data_dir)
    if report is None:
        raise Problem(
            404,
            "no-report",
            "No accuracy report has been made yet. Run `damperlab check accuracy` with the data directory of this service.",
        )
    return Document(report)
