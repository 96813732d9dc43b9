"""This package computes airlight and transmittance along rays."""
