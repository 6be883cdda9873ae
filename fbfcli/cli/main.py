"""The command `fbf`: verbs found when they are asked for, and errors as one line and an exit code."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Sequence
from difflib import get_close_matches
from importlib import import_module

import click

from fbfcli import __version__
from fbfcli.errors import FbfError

VERBS = {  # module and command in fbfcli.cli, and its help in one line: numpy is not imported to print this
    "compensate": "Change a print so that a vibrating printer follows it.",
    "simulate": "Show where the nozzle of a vibrating printer really goes.",
    "steps": "Turn a print into the step pulses of its motors.",
    "excite": "Write a sweep that shows how a printer vibrates, and what it commands.",
    "identify": "Find how an axis vibrates from recordings.",
    "printers": "List the printers fbf knows, and check profiles.",
    "reproduce": "Recompute the papers' tables and figures.",
}
COMPLETE = "_FBF_COMPLETE"  # what click's completion scripts set
INTERRUPTED = 130  # 128 + SIGINT
BROKEN_PIPE = 141  # 128 + SIGPIPE
TERMINATED = 143  # 128 + SIGTERM
THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")  # read when numpy is imported


class Verbs(click.Group):
    """A group whose commands are imported where they are used."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(VERBS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if name not in VERBS:
            near = get_close_matches(name, VERBS, n=1)
            ctx.fail(f"No such command {name!r}." + (f" Did you mean {near[0]!r}?" if near else ""))
        command: click.Command = getattr(import_module(f"fbfcli.cli.{name}"), name)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(VERBS.items()))


@click.group(cls=Verbs, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="fbf", message="%(prog)s %(version)s")
def fbf() -> None:
    """Vibration compensation for G-code machines.

    Every command is a filter: "-" is standard input or output, data goes to standard output, words to standard error.

    \b
    fbf compensate part.gcode -p synthetic_bed_slinger    writes part.fbf.gcode
    fbf compensate - -o - < part.gcode > out.gcode
    fbf printers                                          what -p can name
    """


class Terminated(BaseException):
    """SIGTERM, as an exception: what is half done is cleaned up."""


def _terminate(number: int, frame: object) -> None:
    raise Terminated


def main(arguments: Sequence[str] | None = None) -> None:
    """Run `fbf` and leave with its exit code: 0, 1 for an error, 2 for a wrong command line, 130 where interrupted."""
    signal.signal(signal.SIGTERM, _terminate)
    for variable in THREADS:  # matrices are small here: threads that wait for each other take ten times the CPU
        os.environ.setdefault(variable, "1")
    sys.exit(run(sys.argv[1:] if arguments is None else arguments))


def run(arguments: Sequence[str]) -> int:
    """Exit code of one command line. Every expected failure is one line on standard error."""
    try:
        if os.environ.get(COMPLETE):
            from click.shell_completion import shell_complete

            return shell_complete(fbf, {}, "fbf", COMPLETE, os.environ[COMPLETE])
        with fbf.make_context("fbf", list(arguments)) as context:  # not fbf.main(): it keeps Ctrl-C and EPIPE to itself
            fbf.invoke(context)
        if sys.stdout is not None:
            sys.stdout.flush()  # a full disk is met here, while there is a chance to say so
    except click.exceptions.Exit as leave:
        return leave.exit_code
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except FbfError as error:
        return _leave(f"error: {error}", error.exit_code)
    except (KeyboardInterrupt, click.Abort):
        return _leave("interrupted", INTERRUPTED)
    except Terminated:
        return _leave("terminated", TERMINATED)
    except BrokenPipeError:
        return _leave("", BROKEN_PIPE)
    except MemoryError:
        return _leave("error: out of memory", 1)
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        return _leave(f"error: {place}{error.strerror or error}", 1)
    return 0


def _leave(words: str, code: int) -> int:
    """Say the words on standard error and drop output that cannot be written, lest Python complain of it again."""
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if words:
        click.echo(f"fbf: {words}", err=True)
    return code


if __name__ == "__main__":
    main()
