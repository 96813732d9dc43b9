"""Branching trees: growth, leaf appearances, sway."""
