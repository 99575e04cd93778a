"""Whole-run benchmark: octant beside LAMMPS and OpenMM on the same liquid, speed and force error together.

``python -m validation.bench`` (the last part of ``make bench``) writes a table, a page and a figure to
``validation/results/bench``. Programs that are compared run in turns, round after round, so that whatever else the
machine does falls on all of them; what is reported is the median over the rounds, and ratios are taken within a round.
"""
