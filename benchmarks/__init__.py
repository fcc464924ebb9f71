"""Measurements: ``python -m benchmarks.table1`` and its neighbours print tables."""
