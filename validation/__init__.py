"""Comparison of octant with LAMMPS: the same scripts through both, number by number.

``python -m validation`` runs every script of ``inputs/`` and writes a table, JSON and a plot to ``validation/results``;
``python -m pytest validation`` runs a shorter selection, reads back logs and trajectories, and tests the README.
"""
