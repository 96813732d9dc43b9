"""The process in which scenes/plugins/trial.py imports a plug-in.

argv: the parent's number, the file descriptor for the answer, module:object. The answer is a JSON
list of what went wrong (empty if nothing did) and whether the process forked.
"""

import json
import os
import sys
from contextlib import suppress
from importlib.metadata import EntryPoint

from scenes.processes.streams import end_with_parent


def main() -> None:
    """Import the object, answer, and end without regard to anything that it left running."""
    parent, answer, value = int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]
    end_with_parent(parent)
    forks: list[bool] = []
    os.register_at_fork(before=lambda: forks.append(True), after_in_child=lambda: os._exit(0))
    said = ""
    try:
        EntryPoint("it", value, "lodbench").load()
    except SystemExit as error:
        said = f"it ends the process, as sys.exit({error.code!r}) does"
    except BaseException as error:  # whatever a stranger's code raises
        said = f"{type(error).__name__}: {error}"
    with suppress(Exception):  # it may have closed or replaced them
        sys.stdout.flush()
    os.write(answer, json.dumps([said, bool(forks)]).encode())
    os._exit(0)


if __name__ == "__main__":
    main()
