"""The theory: part hierarchies, the metric family, the pruner and the law's predictions.

Nothing in this package opens a file, reads a clock or imports a renderer.
"""
