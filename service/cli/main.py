"""Entry point of the command line `damperlab`, with the list of commands."""

import atexit
import sys
from functools import cache
from gc import freeze
from typing import Annotated, Any

import typer
from typer.main import get_command

from damperlab.service.cli.accuracy import accuracy
from damperlab.service.cli.asked import Command
from damperlab.service.cli.design import design
from damperlab.service.cli.designs import designs
from damperlab.service.cli.doctor import doctor
from damperlab.service.cli.earthquake import earthquake, records
from damperlab.service.cli.export import export
from damperlab.service.cli.failures import BAD_USAGE, DONE, FAILED, report
from damperlab.service.cli.fit import fit
from damperlab.service.cli.keep import backup, gc, rebuild, restore
from damperlab.service.cli.keys import keys
from damperlab.service.cli.output import note, say
from damperlab.service.cli.queries import command_of
from damperlab.service.cli.report import report as write_report
from damperlab.service.cli.reproduce import reproduce
from damperlab.service.cli.run import run
from damperlab.service.cli.searches import refine
from damperlab.service.cli.serve import serve
from damperlab.service.cli.simulate import simulate
from damperlab.service.cli.store import warn_of_unknown_variables
from damperlab.service.cli.studies import cancel, delete, show, studies, undelete
from damperlab.service.cli.verify import verify
from damperlab.service.cli.versions import recompute
from damperlab.service.cli.warm import warm
from damperlab.service.cli.worker import certificates, worker
from damperlab.service.questions.every import EVERY

INTERRUPTED = 130
"""Exit status that typer returns if Ctrl-C interrupts a command."""


RENAMED = {
    "resume": "run",
    "retry": "run --retry",
    "remark": "show",
    **{name: f"store {name}" for name in ("verify", "backup", "restore", "rebuild", "gc")},
    **{name: f"admin {name}" for name in ("keys", "worker", "certificates")},
    "accuracy": "check accuracy",
    "reproduce": "check paper",
}
"""Present name of each command that had another name in version 0.1. The old names work until version 0.3."""
GONE = {
    "importance": "`damperlab map` shows how a result changes with two parameters, `damperlab response` along the frequency.",
    "race": "Submit the designs again with a smaller `steady.tolerance`.",
    "robust": "Give a study several values of base_amplitude_m and ask `damperlab optimum`, or let `damperlab design` choose.",
}
"""Removed commands, each with the advice that is printed."""


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


store = typer.Typer(help="Verify, back up, restore, rebuild and clean the store.", no_args_is_help=True)
admin = typer.Typer(help="Keys of a service; workers and certificates of a cluster.", no_args_is_help=True)
check = typer.Typer(help="Measure the solver, or compute the paper's results again.", no_args_is_help=True)

ASKED = {first: [command_of(each) for each in EVERY if each.first is first] for first in (True, False)}
"""Commands that evaluate a study, which the help lists under "Ask a study" (True) or under "More" (False)."""
GROUPS: tuple[tuple[typer.Typer, str | None, tuple[Command, ...]], ...] = (
    (app, "Compute", (design, run, simulate, fit, earthquake)),
    (app, "Ask a study", (*ASKED[True], write_report, export)),
    (app, "Look around", (studies, show, serve)),
    (app, "More", (refine, recompute, *ASKED[False], records, cancel, delete, undelete)),
    (app, "Operate", (doctor, warm)),
    (store, None, (verify, backup, restore, rebuild, gc)),
    (admin, None, (worker, certificates)),
    (check, None, (accuracy,)),
)
for group, panel, commands in GROUPS:
    for command in commands:
        group.command(command.__name__, rich_help_panel=panel)(command)
check.command("paper")(reproduce)
app.add_typer(designs, name="designs", rich_help_panel="More")
admin.add_typer(keys, name="keys")
for name, group in (("store", store), ("admin", admin), ("check", check)):
    app.add_typer(group, name=name, rich_help_panel="Operate")


def main() -> None:
    """Run the command that the arguments name, and end the process with the exit status of the command."""
    # `gc.freeze` prevents a garbage collection at the end of the process. A short command then takes a fifth less time.
    atexit.register(freeze)
    sys.exit(_run(sys.argv[1:]))


@cache
def _commands() -> Any:
    """Build the tree of commands, once for all commands that run in this process."""
    return get_command(app)


def _run(arguments: list[str]) -> int:
    if arguments and arguments[0] in GONE:
        note(f"damperlab: there is no `{arguments[0]}` any more. {GONE[arguments[0]]}")
        return BAD_USAGE
    if arguments and arguments[0] in RENAMED:
        name = RENAMED[arguments[0]]
        note(f"damperlab: `{arguments[0]}` is now `{name}`; the old name works until version 0.3.")
        arguments = [*name.split(), *arguments[1:]]
    try:
        # If a command raises typer.Exit, the status of this exception is returned; otherwise None.
        status = _commands()(args=arguments, prog_name="damperlab", standalone_mode=False) or DONE
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
