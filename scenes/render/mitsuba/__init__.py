"""This package builds Mitsuba's objects from a scene description."""
