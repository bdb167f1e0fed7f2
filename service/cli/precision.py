"""The command precision: the error of a study's points against their run time."""

from damperlab.service.cli.options import AsJson, DataDir, StudyId
from damperlab.service.cli.output import number, print_table, say, working
from damperlab.service.cli.queries import ask, hand_out


def precision(study: StudyId, data_dir: DataDir = None, as_json: AsJson = False) -> None:
    """Show the error of a study's points against their run time (work-precision diagram)."""
    record, cube = ask(study, data_dir, "precision")
    from damperlab.service.comparisons import columns_document
    from damperlab.studies.answers.work_precision import work_precision

    with working("Reading the cube"):
        answer = work_precision(cube)

    def tell() -> None:
        names = ("run_time", *(str(name) for name in answer.data_vars))
        rows = zip(*(answer[name].values.tolist() for name in names), strict=True)
        say(answer.attrs["note"])
        print_table(("run_time [s]", *names[1:]), (tuple(number(value, 3) for value in row) for row in rows))

    hand_out(record, answer, None, as_json, None, lambda: columns_document(answer), tell)
