"""The program in this process, as tests start it."""

import pytest


def said(capfd: pytest.CaptureFixture[str], *words: object) -> tuple[int, str, str]:
    """Run a command: its exit code, what it prints, and what it says of errors."""
    from bench.cli.main import main

    with pytest.raises(SystemExit) as left:
        main([*map(str, words)])
    return (int(left.value.code or 0), *capfd.readouterr())
