"""The benchmark on a GPU: ``octant bench`` for every size and scene, OpenMM on the same card in turns with it.

``python -m validation.bench.gpu --results DIR`` measures and writes ``bench.csv`` and ``openmm.csv``, which needs numpy
at most; ``--render DIR`` makes ``speed.md``, ``speed.svg`` and ``speed.png`` of them, anywhere, with matplotlib.
"""
