"""The theory: part hierarchies, the metric family, the pruner and the law's predictions.

Nothing here opens a file, reads a clock or knows a renderer.
"""
