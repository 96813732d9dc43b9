"""This package makes prototypes of imported models: limits, joints and stand-ins of their parts."""
