"""This package has the animals, and a windmill."""
