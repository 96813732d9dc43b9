"""This package says how objects walk: gaits, paths of their feet, and patrols."""
