"""This package renders one frame, from its input to its layers."""
