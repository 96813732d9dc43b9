"""This package has people and animals: their files, bodies, gaits and patrols."""
