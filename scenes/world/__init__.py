"""This package makes a world and the views of it from a preset."""
