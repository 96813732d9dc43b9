"""Jointed objects: anatomy, prototypes, poses, inverse kinematics, bounds."""
