"""octant beside what is known of the Lennard-Jones fluid without it: equations of state, and what statistical mechanics says of
velocities and energies.
"""
