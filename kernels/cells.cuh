// Cells of the grid: where a position is, and places in the table of cells.

// Cell, octant and part of the octant of a wrapped position; returns whether the grid reaches there.
__device__ __forceinline__ bool key_of(const Scene& s, const Point& p, u32 cell[3], u32* octant, u32* part) {
    u32 bits = 0, middles = 0;
    bool inside = true;
    for (u32 axis = 0; axis < 3; axis++) {
        double place, c, eighth;
        locate(p.x[axis], s.grid_lo[axis], s.inverse_edge[axis], s.last_cell[axis], &place, &c, &eighth);
        cell[axis] = (u32)c;
        bits |= SPREAD[(u32)eighth] << axis;
#ifdef MIDPLANE
        double middle;
        is_middle(place, c, s.border[axis], &middle);
        middles |= (u32)middle << axis;
#endif
        // Beyond the last cell of a free axis a particle belongs to it, but fixed-point coordinates reach one cell further only.
        inside &= place >= -1.0 && place <= s.last_cell[axis] + 2.0;
    }
    *octant = bits >> PART_BITS & DIVIDED;
#ifdef COMPACT
    *part = bits & ((1u << PART_BITS) - 1);
#else
    *part = middles;
#endif
    return inside;
}

// Number of a cell or bin among so many.
__device__ __forceinline__ u32 number_of(u32 x, u32 y, u32 z, const u32 counts[3]) {
    const double cell[3] = {(double)x, (double)y, (double)z};
    const double cells[3] = {(double)counts[0], (double)counts[1], (double)counts[2]};
    double number;
    row_major(cell, cells, &number);
    return (u32)number;
}

// Place of a cell in the table: cells far apart may share one where the grid is mostly empty.
__device__ __forceinline__ u32 table_of(const Scene& s, u32 x, u32 y, u32 z) {
#ifdef FOLDED
    x %= s.table[0], y %= s.table[1], z %= s.table[2];
#endif
#ifdef CURVE
    return (u32)(apart(x) | apart(y) << 1 | apart(z) << 2);
#else
    return number_of(x, y, z, s.table);
#endif
}

__device__ __forceinline__ u64 cell_number(const u32 cell[3]) {
    return (u64)cell[2] << 2 * CELL_BITS | (u64)cell[1] << CELL_BITS | cell[0];
}

// Which cells the particles of a warp look into together, each thread with a particle of one octant: a place in the table of
// visits.
__device__ __forceinline__ u32 visits_of(const Arrays& a, const Scene& s, const Run& r, u32 octant, u32 k) {
#ifdef MIDPLANE
    Point p;
    for (u32 axis = 0; axis < 3; axis++) p.x[axis] = axis_of(side_of(a.held_x, s, r.parity, 3), s, axis)[k];
    u32 cell[3], own, part, shared = 0;
    key_of(s, p, cell, &own, &part);
    for (u32 axis = 0; axis < 3; axis++) shared |= (u32)(__all_sync(~0u, part >> axis & 1) != 0) << axis;
    return octant * OCTANTS + shared;
#else
    return octant;
#endif
}
