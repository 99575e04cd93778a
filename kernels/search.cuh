// The list: BUILD_LANES threads a particle look through the octants that can hold its neighbors.
//
// Row i of the list has counts[i] entries; entry k stands at ((k / LANES) * pitch + i) * LANES + k % LANES, so that LANES
// threads of the force stage read one after the other. An entry is the neighbor's place and, in the bits above INDEX_BITS,
// the number of the periodic image it is seen in.

// Whether j, seen in an image, is a neighbor of i: decided in double precision, with LAMMPS's rounding across a side.
__device__ __noinline__ bool is_neighbor(const Arrays& a, const Scene& s, const Run& r, u32 i, u32 j, int ix, int iy, int iz, double limit) {
    double xi[3], xj[3];
    for (u32 axis = 0; axis < 3; axis++) {
        const double* x = axis_of(side_of(a.held_x, s, r.parity, 3), s, axis);
        xi[axis] = x[i];
        xj[axis] = x[j];
    }
    const double image[3] = {(double)ix, (double)iy, (double)iz};
    double r2;
    squared_distance(xi, xj, image, s, &r2);
#if PERIODIC
    if ((ix | iy | iz) != 0 && fabs(r2 - limit) <= s.tie_band * limit) {
        tied_squared_distance(xi, xj, image, s, &r2);
        return limit > 0.0 && r2 <= limit;
    }
#endif
    return r2 <= limit;
}

// Brings a neighbor cell into the grid; returns false where there is none.
__device__ __forceinline__ bool enter(const Scene& s, u32 axis, i64& cell, int& image) {
    const i64 cells = (i64)s.last_cell[axis] + 1;
    image = 0;
    if (PERIODIC >> axis & 1) {
        while (cell < 0) cell += cells, image--;
        while (cell >= cells) cell -= cells, image++;
        return true;
    }
    return cell >= 0 && cell < cells;
}

__device__ __forceinline__ u32 write_entries(const Arrays& a, const Scene& s, u32 i, u32 count, bool in, Entry entry) {
#if BUILD_LANES > 1
    const u32 shift = (threadIdx.x & 31) & ~(BUILD_LANES - 1);
    const u32 group = (BUILD_LANES == 32 ? ~0u : ((1u << (BUILD_LANES & 31)) - 1)) << shift;
    const u32 bits = __ballot_sync(group, in) & group;
    const u32 k = count + __popc(bits & ((1u << (threadIdx.x & 31)) - 1));
    const u32 added = __popc(bits);
#else
    const u32 k = count, added = in;
#endif
    if (in && k < s.capacity) a.list[((u64)(k / LANES) * s.pitch + i) * LANES + k % LANES] = entry;
    return count + added;
}

__device__ void build_list(const Arrays& a, const Scene& s, const Run& r) {
    for (u32 k = THREAD; k < r.n; k += THREADS) {
        store x[3];
        for (u32 axis = 0; axis < 3; axis++) {
#ifdef DISPLACEMENTS
            x[axis] = 0;
#else
            x[axis] = axis_of(side_of(a.held_x, s, r.parity, 3), s, axis)[k];
#endif
            axis_of(a.x, s, axis)[k] = x[axis];
            axis_of(a.v, s, axis)[k] = axis_of(side_of(a.held_v, s, r.parity, 3), s, axis)[k];
        }
        pack(a, s, r, k, x, kind_of(a, s, r, k));
    }
    const u32 lane = threadIdx.x % BUILD_LANES;
    u64 entries = 0, tests = 0;
    u32 most = 0;
    for (u32 i = THREAD / BUILD_LANES; i < r.n; i += THREADS / BUILD_LANES) {
        Point p;
        for (u32 axis = 0; axis < 3; axis++) p.x[axis] = axis_of(side_of(a.held_x, s, r.parity, 3), s, axis)[i];
        u32 cell[3], octant, part;
        key_of(s, p, cell, &octant, &part);
        const int4 own = a.fixed[i];
        u32 count = 0;
        for (u32 v = a.visit_starts[octant]; v < a.visit_starts[octant + 1]; v++) {
            const int4 visit = a.visits[v];
            i64 cx = (i64)cell[0] + visit.x, cy = (i64)cell[1] + visit.y, cz = (i64)cell[2] + visit.z;
            int ix, iy, iz;
            if (!enter(s, 0, cx, ix) || !enter(s, 1, cy, iy) || !enter(s, 2, cz, iz)) continue;
            const u32 first_octant = table_of(s, (u32)cx, (u32)cy, (u32)cz) * 8;
#ifdef IMAGES
            const u32 code = ((iz + s.images[2]) * (2 * s.images[1] + 1) + iy + s.images[1]) * (2 * s.images[0] + 1) + ix + s.images[0];
            const int4 shift = a.fixed_shifts[code];
#endif
#ifdef FOLDED
            const u64 wanted_cell = (u64)cz << 40 | (u64)cy << 20 | (u64)cx;
#endif
            for (u32 o = 0; o < 8; o++) {
                if (!(visit.w >> o & 1)) continue;
                // Octants wanted one after the other are one run.
                const u32 begin = a.starts[first_octant + o];
                while (o < 7 && visit.w >> (o + 1) & 1) o++;
                const u32 end = a.starts[first_octant + o + 1];
                tests += end - begin;
                for (u32 base = begin; base < end; base += BUILD_LANES) {
                    const u32 j = base + lane;
                    bool in = false;
                    if (j < end) {
                        int4 q = a.fixed[j];
#ifdef IMAGES
                        q.x += shift.x, q.y += shift.y, q.z += shift.z;
#endif
                        const float dx = (float)(own.x - q.x) * s.scale[0];
                        const float dy = (float)(own.y - q.y) * s.scale[1];
                        const float dz = (float)(own.z - q.z) * s.scale[2];
                        const float r2 = dx * dx + dy * dy + dz * dz;
#if TYPES > 1
                        const Limit limit = a.limits[own.w * TYPES + q.w];
#else
                        const Limit limit = a.limits[0];
#endif
                        in = r2 < limit.inner;
                        if (!in && r2 <= limit.outer) in = is_neighbor(a, s, r, i, j, ix, iy, iz, limit.squared);
                        if (j == i && (ix | iy | iz) == 0) in = false;
#ifdef FOLDED
                        if (in) {
                            Point pj;
                            for (u32 axis = 0; axis < 3; axis++) pj.x[axis] = axis_of(side_of(a.held_x, s, r.parity, 3), s, axis)[j];
                            u32 cell_j[3], octant_j, part_j;
                            key_of(s, pj, cell_j, &octant_j, &part_j);
                            in = cell_number(cell_j) == wanted_cell;
                        }
#endif
                    }
#ifdef IMAGES
                    const Entry entry = (Entry)code << INDEX_BITS | j;
#else
                    const Entry entry = j;
#endif
                    count = write_entries(a, s, i, count, in, entry);
                }
            }
        }
        if (lane == 0) {
            a.neighbors[i] = count;
            entries += count;
        }
        most = count > most ? count : most;
    }
    if (lane == 0 && entries | tests) {
        atomicAdd(&a.control->entries, entries);
        atomicAdd(&a.control->tests, tests);
    }
    if (most > s.capacity) atomicMax(&a.control->wanted, most);
}
