"""The human stick figure."""
