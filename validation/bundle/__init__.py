"""The bundle: octant's tests, a sanitizer, the comparison with LAMMPS and the benchmark, for a GPU machine without toolchain.

``make gpu-bundle`` gathers it on the machine that has Rust and LAMMPS (``make``); ``run.sh`` in it runs everything else
here, which asks for Python's standard library alone, and for numpy in comparison and benchmark.
"""
