"""Frames as OpenEXR files: layers, header, and the sequence that lies in a folder."""
