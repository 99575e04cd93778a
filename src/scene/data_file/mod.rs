//! LAMMPS data files.
