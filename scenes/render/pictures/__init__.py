"""This package makes pictures and films for people to look at."""
