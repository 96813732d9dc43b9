"""Films in which nothing should pop or stutter, and what motion does not explain of them.

``walk`` goes through a small forest, unpruned, fading and clipped; ``clips`` pans, walks, stops and
flies, pruned and with everything drawn. Both move what a frame displays to where it is in the next,
and measure what the next shows otherwise (``unexplained_change``).
"""

import click

from bench.studies.films.clips import command as clips
from bench.studies.films.forest_walk import command as walk


@click.group("films")
def command() -> None:
    """Render films, and measure what motion does not explain of them."""


command.add_command(walk, "walk")
command.add_command(clips, "clips")
