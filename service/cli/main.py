"""Entry point of `damperlab`: the commands by name, and the exit status of whatever happens in them."""

import atexit
import sys
from gc import freeze
from typing import Annotated

import typer

from damperlab.service.cli.accuracy import accuracy
from damperlab.service.cli.asked import Command
from damperlab.service.cli.design import design
from damperlab.service.cli.doctor import doctor
from damperlab.service.cli.earthquake import earthquake, records
from damperlab.service.cli.export import export
from damperlab.service.cli.failures import BAD_USAGE, DONE, FAILED, report
from damperlab.service.cli.fit import fit
from damperlab.service.cli.keep import backup, gc, rebuild, restore
from damperlab.service.cli.keys import keys
from damperlab.service.cli.members import certificates, worker
from damperlab.service.cli.output import note, say
from damperlab.service.cli.queries import command_of
from damperlab.service.cli.report import report as write_report
from damperlab.service.cli.reproduce import reproduce
from damperlab.service.cli.run import resume, run
from damperlab.service.cli.searches import refine
from damperlab.service.cli.serve import serve
from damperlab.service.cli.simulate import simulate
from damperlab.service.cli.store import warn_of_unknown_variables
from damperlab.service.cli.studies import cancel, delete, remark, show, studies
from damperlab.service.cli.verify import verify
from damperlab.service.cli.versions import recompute, retry
from damperlab.service.cli.warm import warm
from damperlab.service.questions.every import EVERY

INTERRUPTED = 130
"""What typer returns for Ctrl-C in a command that does not handle it itself."""


GONE = {
    "race": "Submit the designs again with a smaller `steady.tolerance`.",
    "robust": "Give a study several values of base_amplitude_m and ask `damperlab optimum`, or let `damperlab design` choose.",
}
"""Commands of earlier versions, with what to do in their place."""


def _print_version(asked: bool) -> None:
    if asked:
        import damperlab

        say(f"damperlab {damperlab.__version__}")
        raise typer.Exit


app = typer.Typer(
    name="damperlab",
    epilog="Exit status: 0 done, 1 failed, 2 bad usage or bad study.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)


@app.callback()
def _before(
    version: Annotated[
        bool,
        typer.Option("--version", help="Print the version and exit.", callback=_print_version, is_eager=True),
    ] = False,
) -> None:
    """Parameter studies of a hybrid vibration damper: particle impact and Coulomb friction."""
    warn_of_unknown_variables()


_COMMANDS: tuple[tuple[str, Command, str], ...] = (
    ("run", run, "Compute"),
    ("resume", resume, "Compute"),
    ("retry", retry, "Compute"),
    ("recompute", recompute, "Compute"),
    ("refine", refine, "Compute"),
    ("design", design, "Compute"),
    ("simulate", simulate, "Compute"),
    ("fit", fit, "Compute"),
    ("reproduce", reproduce, "Compute"),
    ("earthquake", earthquake, "Compute"),
    ("records", records, "Compute"),
    *((question.command, command_of(question), "Ask") for question in EVERY),
    ("report", write_report, "Ask"),
    ("export", export, "Ask"),
    ("studies", studies, "Keep"),
    ("show", show, "Keep"),
    ("remark", remark, "Keep"),
    ("cancel", cancel, "Keep"),
    ("delete", delete, "Keep"),
    ("verify", verify, "Keep"),
    ("backup", backup, "Keep"),
    ("restore", restore, "Keep"),
    ("rebuild", rebuild, "Keep"),
    ("gc", gc, "Keep"),
    ("serve", serve, "Serve"),
    ("worker", worker, "Serve"),
    ("certificates", certificates, "Serve"),
    ("accuracy", accuracy, "Serve"),
    ("doctor", doctor, "Serve"),
    ("warm", warm, "Serve"),
)
for name, command, panel in _COMMANDS:
    app.command(name, rich_help_panel=panel)(command)


app.add_typer(keys, name="keys", rich_help_panel="Serve")


def main() -> None:
    """Run the command that the arguments name, and end the process with its exit status."""
    # What was loaded need not be looked through for garbage as the process ends: a fifth of what a short command takes.
    atexit.register(freeze)
    sys.exit(_run(sys.argv[1:]))


def _run(arguments: list[str]) -> int:
    if arguments and arguments[0] in GONE:
        note(f"damperlab: there is no `{arguments[0]}` any more. {GONE[arguments[0]]}")
        return BAD_USAGE
    try:
        # A command ends early with typer.Exit(status), which is returned here; one that is done returns None.
        status = app(args=arguments, prog_name="damperlab", standalone_mode=False) or DONE
    except typer.Abort:
        note("damperlab: stopped; nothing was changed.")
        return FAILED
    except Exception as error:
        return report(error, as_json="--json" in arguments)
    if status == INTERRUPTED:
        note("damperlab: interrupted.")
        return FAILED
    return int(status)


if __name__ == "__main__":
    main()
