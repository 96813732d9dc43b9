"""This package poses jointed objects: anatomy, poses, inverse kinematics, bounds."""
