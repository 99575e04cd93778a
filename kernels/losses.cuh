// Particles that leave the box and are lost: told to the host, which knows what becomes of storage order then, and taken out as it
// says. The first column of `losses` has their places and then those of particles that fill holes; the second the axes they are
// lost along, then the holes; the third their places in storage order, then those which particles at its end get.

#ifdef LOSES
// Tells the host of particle k, outside the box at p.
__device__ void tell_lost(const Arrays& a, const Scene& s, const Run& r, u32 k, const Point& p) {
    const u32 at = atomicAdd(&a.control->lost, 1u);
    if (at >= MOST_LOST) return;
    u32 axis = 0;
    while (axis < 2 && p.x[axis] >= s.lo[axis] && p.x[axis] < s.hi[axis]) axis++;
    a.losses[at] = k;
    a.losses[MOST_LOST + at] = axis;
    a.losses[2 * MOST_LOST + at] = side_of(a.held_home, s, r.parity, 1)[k];
}

// Moves the last particles into the holes that lost ones leave.
__device__ void fill_holes(const Arrays& a, const Scene& s, Run& r) {
    const u32 holes = read_flag(&a.control->holes);
    if (!holes) return;
    for (u32 hole = THREAD; hole < holes; hole += THREADS) {
        const u32 from = a.losses[hole], to = a.losses[MOST_LOST + hole];
        // One of the last leaves no hole.
        if (from == to) continue;
        for (u32 axis = 0; axis < 3; axis++) {
            axis_of(a.x, s, axis)[to] = axis_of(a.x, s, axis)[from];
            axis_of(a.v, s, axis)[to] = axis_of(a.v, s, axis)[from];
            double* x = axis_of(side_of(a.held_x, s, r.parity, 3), s, axis);
            x[to] = x[from];
            auto* v = axis_of(side_of(a.held_v, s, r.parity, 3), s, axis);
            v[to] = v[from];
            int* image = axis_of(side_of(a.held_image, s, r.parity, 3), s, axis);
            image[to] = image[from];
        }
        u32* id = side_of(a.held_id, s, r.parity, 1);
        id[to] = id[from];
        u32* source = side_of(a.held_source, s, r.parity, 1);
        source[to] = source[from];
        u32* home = side_of(a.held_home, s, r.parity, 1);
        home[to] = home[from];
#if TYPES > 1
        u32* kind = side_of(a.held_kind, s, r.parity, 1);
        kind[to] = kind[from];
#endif
#ifdef GROUPS
        u32* mask = side_of(a.held_mask, s, r.parity, 1);
        mask[to] = mask[from];
#endif
    }
    sync_grid(a, r);
    u32* home = side_of(a.held_home, s, r.parity, 1);
    for (u32 k = THREAD; k < r.n; k += THREADS)
        if (home[k] >= r.n) home[k] = a.losses[2 * MOST_LOST + home[k] - r.n];
    if (THREAD == 0) a.control->holes = 0;
    sync_grid(a, r);
}
#endif
