"""Cuts that hold from one frame to the next."""
