"""The models that a species can have."""
