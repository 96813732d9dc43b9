"""This package grows a sward: tufts of blades, seed heads and flowers."""
