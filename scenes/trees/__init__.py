"""This package has the trees: their growth, leaf appearances and sway."""
