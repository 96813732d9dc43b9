"""This package makes prototypes of imported models: limits, joints and appearances."""
