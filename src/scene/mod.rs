//! The meaning of a script: lattices, regions, atoms, velocities, data files.
