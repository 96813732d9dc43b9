"""The program `lodbench`: its commands, and how it ends, with one line if something went wrong."""

import atexit
import errno
import importlib
import os
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

import click

from bench.cli.kernel_cache import use_kernel_cache
from bench.cli.output import progress_shown
from lod.errors import InputError
from scenes.processes.streams import (
    Stopped,
    ignore_signals,
    is_unread,
    open_standard_streams,
    raise_when_stopped,
    restore,
    write_failure,
)

EXAMPLES = """\
doctor --check blake
list --keys meadow
show meadow
count meadow --detail 2
render fly_in -o out/f.####.exr --frames 1-24 --size 640x360 --visibility 2km --motion --preview
view out/f.0001.exr -o levels.png --view level
verify out --frames 1-24 --repair
run law --quick -o out/records
report out/records
compare out/records results/reference
frames --print-commands meadow -o out/a.####.exr --frames 1-24
usd meadow -o cut.usdc
pack make crowd-small -o packs/crowd
pack render packs/crowd --kept kept.bin -o a.exr
score still.exr --pack packs/crowd --seconds 12.5
model add oak.usda -o oak.png
model list
model show oak
model remove oak
act playground -o out
ask playground "joe right arm/hand where" --frame 12
environments cycles
observe make out/observe --small
observe fit out/files/1.json --of out/observe -o out/records
observe simulate out/observe -o out/files""".splitlines()
"""Of each command, in the order in which they are first needed."""

COMMANDS = tuple(dict.fromkeys(each.split()[0] for each in EXAMPLES))
OK, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
TRACEBACK = "LODBENCH_TRACEBACK"
COMPLETION = "_LODBENCH_COMPLETE"
CURES = {
    errno.ENOSPC: "make room",
    errno.EDQUOT: "make room",
    errno.EROFS: "choose a place on a disk that may be written to",
    errno.EACCES: "change its permissions, or choose another place",
    errno.EPERM: "change its permissions, or choose another place",
    errno.ENOENT: "see that it stays where it is",
    errno.ENOTDIR: "move away the file that is in a folder's place",
    errno.EISDIR: "move away the folder that is in a file's place",
    errno.EEXIST: "move away what is there",
    errno.EMFILE: "allow more open files, as by `ulimit -n 4096`",
    errno.ENFILE: "close other programs",
    errno.ENAMETOOLONG: "choose a shorter name",
    errno.ESTALE: "mount its disk again",
    errno.EIO: "look after the disk",
}
"""What helps against errors of the operating system."""

PACKAGES = {"libatomic.so.1": "libatomic1", "libGL.so.1": "libgl1"}
"""Packages of Debian that bring a library, where it is not named like it."""


class Commands(click.Group):
    """Group that imports a command only when it is asked for, so that mistakes are fast."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Name the commands, in the order in which they are first needed."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import the command of that name; None for an unknown one."""
        if cmd_name not in COMMANDS:
            return None
        use_kernel_cache()
        command: click.Command = importlib.import_module(f"bench.cli.commands.{cmd_name}").command
        within = command.commands if isinstance(command, click.Group) else {}
        for each in EXAMPLES:
            name, below, *_ = each.split()
            if name == cmd_name:
                within.get(below, command).epilog = f"\b\nExample: lodbench {each}"
        return command


def _say_version(ctx: click.Context, _: click.Parameter, asked: bool) -> None:
    if not asked or ctx.resilient_parsing:
        return
    from importlib import metadata

    try:
        version = metadata.version("lodbench")
    except metadata.PackageNotFoundError:
        version = "unknown (not installed)"
    click.echo(f"lodbench, version {version}")
    ctx.exit()


@click.group(
    cls=Commands,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_say_version,
    help="Show the version and exit.",
)
@click.pass_context
def program(ctx: click.Context) -> None:
    """How does the cost of a natural scene grow, when detail is what the viewer can resolve?"""
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run one command and leave with its code: 0 ok, 1 failed, 2 bad input, 128 + n for signal n.

    What stdout does not take ends no command: that it was lost is said at the end, and fails it;
    but a reader that went away, as that of ``| head`` does, had what it wanted.
    """
    open_standard_streams()
    if asked := os.environ.get(COMPLETION):
        _complete(asked)
    words = list(sys.argv[1:] if arguments is None else arguments)
    code, line, before = OK, "", raise_when_stopped()
    try:
        with program.make_context("lodbench", words) as context, progress_shown():
            _require_current_folder()
            program.invoke(context)
    except BaseException as error:
        if os.environ.get(TRACEBACK) and not isinstance(error, click.exceptions.Exit):
            raise
        code, line = _verdict(error)
    if code <= 128:
        ignore_signals()  # the command has ended: a signal that comes now would only hide how
    lost = write_failure(sys.stdout)
    if lost and not is_unread(lost):
        what = f"error: stdout could not be written ({lost.strerror}): what was printed is lost"
        code, line = code or FAILED, f"{line}; {what}" if line else f"{what}, the work is done"
    if line:
        click.echo(f"lodbench: {line}", err=True)
    if code <= 128:
        restore(before)
    # While the interpreter ends there is no handler any more: a signal would kill it.
    atexit.register(ignore_signals)
    sys.exit(code)


def _require_current_folder() -> None:
    """Raise InputError where the current folder was removed: Mitsuba aborts the process there."""
    try:
        Path.cwd()
    except FileNotFoundError:
        rule = "a folder that is there, which relative paths begin from"
        raise InputError("current folder", "removed", rule, "change to another") from None


def _complete(asked: str) -> NoReturn:
    from click.shell_completion import shell_complete

    sys.exit(shell_complete(program, {}, "lodbench", COMPLETION, asked))


def _verdict(error: BaseException) -> tuple[int, str]:
    """Give the exit code of an error, and the one line that says why."""
    match error:
        case click.exceptions.Exit():
            return error.exit_code, ""
        case Stopped():
            return error.exit_code, "interrupted"
        case KeyboardInterrupt() | click.Abort():
            return INTERRUPTED, "interrupted"
        case InputError():
            return BAD_INPUT, f"error: {_one_line(str(error))}"
        case click.UsageError():
            seen = f" (see `{error.ctx.command_path} --help`)" if error.ctx else ""
            return BAD_INPUT, f"error: {_one_line(error.format_message())}{seen}"
        case click.ClickException():
            return FAILED, f"error: {_one_line(error.format_message())}"
        case MemoryError():
            return FAILED, "error: out of memory: ask for less detail, density or size"
        case OSError():
            return _refused_by_system(error)
    if missing := _missing_library(error):
        cure = f"install it, as by `apt-get install {PACKAGES.get(missing, missing)}`"
        return FAILED, f"error: a package needs {missing} of the system, which is not there; {cure}"
    name = type(error).__name__
    return FAILED, f"error: {name}: {_one_line(str(error))} ({TRACEBACK}=1 shows where)"


def _missing_library(error: BaseException | None) -> str | None:
    """Name the shared library of the system for want of which a package was not imported."""
    while error:
        found = re.match(r"(\S+\.so[.\d]*): cannot open shared object file", str(error))
        if found and isinstance(error, ImportError):
            return found[1]
        error = error.__cause__ or error.__context__
    return None


def _refused_by_system(error: OSError) -> tuple[int, str]:
    """Say which file it was, and what helps; a current folder that has gone is bad input."""
    from scenes.files import DiskError

    try:
        _require_current_folder()
    except InputError as gone:
        return _verdict(gone)
    if isinstance(error, DiskError):  # it says what helps
        return FAILED, f"error: {_one_line(str(error))}"
    cure = CURES.get(error.errno or 0, "put that right")
    what = _one_line(str(error) or type(error).__name__)
    return FAILED, f"error: {what}; {cure}, then give the same command again"


def _one_line(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= 600 else line[:599] + "…"


if __name__ == "__main__":
    main()
