"""Jointed bodies: prototypes, poses, inverse kinematics, bounds."""
