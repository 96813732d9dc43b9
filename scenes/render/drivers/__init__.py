"""This package samples a built scene, with one driver for each kind of variant."""
