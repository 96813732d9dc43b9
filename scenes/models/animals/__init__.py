"""The animals, and a windmill."""
