"""This package has the live actors of a scene: they act by messages, frame after frame."""
