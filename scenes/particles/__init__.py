"""This package has particle systems: smoke, flames, and dust behind walkers."""
