"""This package keeps processes in order: their streams, their signals, and when they end."""
