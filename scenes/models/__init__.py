"""This package has the models that a species can have."""
