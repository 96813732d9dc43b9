"""`lodbench cache`: what is kept from one run to the next, and where."""

import click

from bench.cli.flags import StrictCommand
from bench.cli.output import output, table
from lod.errors import InputError
from scenes.processes.cache import VARIABLE


@click.command("cache", cls=StrictCommand)
@click.option("--clear", is_flag=True, help="Remove all of it; the next command makes it again.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def command(clear: bool, as_json: bool) -> None:
    """What is kept from one run to the next, its size, and where it lies.

    Grown trees, their tables and compiled kernels are kept so that commands start at once. Nothing
    needs them. LODBENCH_CACHE names another folder.
    """
    from scenes.processes.cache import LIMIT_BYTES, cache_contents, clear_cache, writable_cache

    folder = writable_cache()
    if folder is None:
        rule = "the cache is a folder that can be written to, and there is none"
        raise InputError("cache", None, rule, f"set {VARIABLE} to a folder")
    if clear:
        clear_cache(folder)
    found = cache_contents(folder)
    size = sum(each.size_bytes for each in found)
    with output(as_json) as out:
        kinds = {each.kind: {"files": each.entries, "bytes": each.size_bytes} for each in found}
        out.record({"folder": folder, "bytes": size, "limit_bytes": LIMIT_BYTES, "kinds": kinds})
        out.say(f"{folder}: {size / 1e6:.1f} MB")
        if found:
            rows = [(each.kind, each.entries, f"{each.size_bytes / 1e6:.1f} MB") for each in found]
            out.say(table([("", "files", "size"), *rows]))
