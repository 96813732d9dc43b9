"""This package finds, reads and checks the data files that describe models."""
