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

// How many of `count` cells belong to the brick that begins at a cell.
__device__ __forceinline__ u32 brick_at(u32 begin, u32 count) { return min((u32)BRICK, count - begin); }

// Place of a cell in the table: cells far apart may share one where the grid is mostly empty. Unless a curve is asked for, cells
// follow each other brick by brick, X fastest, and so in a brick: what the whole device works on at a time then has few neighbors
// beyond itself, and particles that are read for several layers of cells are still in the second-level cache.
__device__ __forceinline__ u32 table_of(const Scene& s, u32 x, u32 y, u32 z) {
#ifdef FOLDED
    x %= s.table[0], y %= s.table[1], z %= s.table[2];
#endif
#ifdef CURVE
    return (u32)(apart(x) | apart(y) << 1 | apart(z) << 2);
#else
    const u32 xx = x % BRICK, yy = y % BRICK, zz = z % BRICK;
    const u32 dx = brick_at(x - xx, s.table[0]), dy = brick_at(y - yy, s.table[1]), dz = brick_at(z - zz, s.table[2]);
    return s.table[0] * (s.table[1] * (z - zz) + dz * (y - yy)) + dz * dy * (x - xx) + (zz * dy + yy) * dx + xx;
#endif
}

// The cell at a place in the table.
__device__ __forceinline__ void cell_at(const Scene& s, u32 place, u32 cell[3]) {
#ifdef CURVE
    for (u32 axis = 0; axis < 3; axis++) {
        cell[axis] = 0;
        for (u32 bit = 0; 3 * bit + axis < 32; bit++) cell[axis] |= (place >> (3 * bit + axis) & 1) << bit;
    }
#else
    const u32 nx = s.table[0], ny = s.table[1];
    const u32 z = place / (BRICK * nx * ny) * BRICK, dz = brick_at(z, s.table[2]);
    place -= z * nx * ny;
    const u32 y = place / (BRICK * nx * dz) * BRICK, dy = brick_at(y, ny);
    place -= y * nx * dz;
    const u32 x = place / (BRICK * dy * dz) * BRICK, dx = brick_at(x, nx);
    place -= x * dy * dz;
    cell[0] = x + place % dx, cell[1] = y + place / dx % dy, cell[2] = z + place / dx / dy;
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
