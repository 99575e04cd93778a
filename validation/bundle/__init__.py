"""The bundle: octant's tests, a sanitizer and the comparison with LAMMPS, for a machine with a GPU and no toolchain.

``make gpu-bundle`` gathers it on the machine that has Rust and LAMMPS (``make``); ``run.sh`` in it runs everything else
here, which asks for Python's standard library alone, and for numpy in the comparison.
"""
