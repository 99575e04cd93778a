// The list: a warp an octant. Its particles have the same candidates, so the warp looks at 32 candidates side by side, drops
// those out of reach of all its particles, and then tests the rest one after the other, a thread a particle.
//
// Row i of the list has neighbors[i] entries; entry k stands at ((k / CHUNK) * pitch + i) * CHUNK + k % CHUNK, so that a chunk
// is read at once and chunks of neighboring rows stand side by side. An entry is the neighbor's place and, in the bits above
// INDEX_BITS, the number of the periodic image it is seen in.

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

// The neighbor's place in an entry.
__device__ __forceinline__ u32 place_of(Entry entry) {
#ifdef IMAGES
    return (u32)(entry & (((Entry)1 << INDEX_BITS) - 1));
#else
    return entry;
#endif
}

// A thread's row: entries gather in a chunk until it is full.
struct Row {
    u32 count;
    Chunk chunk;
};

__device__ __forceinline__ void store_chunk(const Arrays& a, const Scene& s, u32 i, u32 k, const Chunk& chunk) {
    if (k < s.capacity) a.list[(u64)(k / CHUNK) * s.pitch + i] = chunk;
}

__device__ __forceinline__ void add_entry(const Arrays& a, const Scene& s, u32 i, Row& row, Entry entry) {
    for (u32 m = 0; m + 1 < CHUNK; m++) row.chunk.entry[m] = row.chunk.entry[m + 1];
    row.chunk.entry[CHUNK - 1] = entry;
    if (++row.count % CHUNK == 0) store_chunk(a, s, i, row.count - CHUNK, row.chunk);
}

// The last chunk; its entries have moved up to its end.
__device__ __forceinline__ void close_row(const Arrays& a, const Scene& s, u32 i, Row& row) {
    if (row.count % CHUNK == 0) return;
    for (u32 more = CHUNK - row.count % CHUNK; more > 0; more--)
        for (u32 m = 0; m + 1 < CHUNK; m++) row.chunk.entry[m] = row.chunk.entry[m + 1];
    store_chunk(a, s, i, row.count / CHUNK * CHUNK, row.chunk);
}

// Distance of a coordinate from an interval, all in fixed point relative to `from`.
__device__ __forceinline__ float gap(int x, int from, float low, float high) {
    const float d = (float)(x - from);
    return fmaxf(fmaxf(low - d, d - high), 0.0f);
}

__device__ void build_list(const Arrays& a, const Scene& s, const Run& r) {
    __shared__ int4 near[BLOCK / 32][32];
    __shared__ Entry near_entry[BLOCK / 32][32];
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
    const u32 lane = threadIdx.x & 31, warp = threadIdx.x >> 5;
#if TYPES == 1
    const Limit limit = a.limits[0];
#endif
    u64 entries = 0, tests = 0;
    u32 most = 0;
    for (u32 bucket = THREAD >> 5; bucket < s.buckets; bucket += THREADS >> 5) {
        const u32 end_i = a.starts[bucket + 1];
        u32 first_i = a.starts[bucket];
        while (first_i < end_i) {
            const u32 i = first_i + lane, begin_i = first_i;
            // Particles of the first one's cell: all, but where cells share a place in the table.
            bool active = i < end_i;
            Point p;
            for (u32 axis = 0; axis < 3; axis++)
                p.x[axis] = axis_of(side_of(a.held_x, s, r.parity, 3), s, axis)[active ? i : first_i];
            u32 cell[3], octant, part;
            key_of(s, p, cell, &octant, &part);
#ifdef FOLDED
            const u64 number = cell_number(cell);
            active &= number == __shfl_sync(~0u, number, 0);
            for (u32 axis = 0; axis < 3; axis++) cell[axis] = __shfl_sync(~0u, cell[axis], 0);
#endif
            first_i += __popc(__ballot_sync(~0u, active));
            const int4 own = a.fixed[active ? i : first_i - 1];
            const int4 from = make_int4(__shfl_sync(~0u, own.x, 0), __shfl_sync(~0u, own.y, 0), __shfl_sync(~0u, own.z, 0), 0);
            float low[3] = {(float)(own.x - from.x), (float)(own.y - from.y), (float)(own.z - from.z)}, high[3];
            for (u32 axis = 0; axis < 3; axis++) {
                high[axis] = low[axis];
                for (u32 d = 16; d > 0; d >>= 1) {
                    low[axis] = fminf(low[axis], __shfl_xor_sync(~0u, low[axis], d));
                    high[axis] = fmaxf(high[axis], __shfl_xor_sync(~0u, high[axis], d));
                }
            }
            Row row = {0};
            for (u32 v = a.visit_starts[octant]; v < a.visit_starts[octant + 1]; v++) {
                const int4 visit = a.visits[v];
                i64 cx = (i64)cell[0] + visit.x, cy = (i64)cell[1] + visit.y, cz = (i64)cell[2] + visit.z;
                int ix, iy, iz;
                if (!enter(s, 0, cx, ix) || !enter(s, 1, cy, iy) || !enter(s, 2, cz, iz)) continue;
                const u32 first_octant = table_of(s, (u32)cx, (u32)cy, (u32)cz) * 8;
                const bool own_image = (ix | iy | iz) == 0;
#ifdef IMAGES
                const u32 code = ((iz + s.images[2]) * (2 * s.images[1] + 1) + iy + s.images[1]) * (2 * s.images[0] + 1) + ix + s.images[0];
                const int4 shift = a.fixed_shifts[code];
#endif
#ifdef FOLDED
                const u32 wanted[3] = {(u32)cx, (u32)cy, (u32)cz};
                const u64 wanted_cell = cell_number(wanted);
#endif
                for (u32 o = 0; o < 8; o++) {
                    if (!(visit.w >> o & 1)) continue;
                    // Octants wanted one after the other are one run.
                    const u32 begin = a.starts[first_octant + o];
                    while (o < 7 && visit.w >> (o + 1) & 1) o++;
                    const u32 end = a.starts[first_octant + o + 1];
                    tests += (u64)(end - begin) * (first_i - begin_i);
                    for (u32 base = begin; base < end; base += 32) {
                        const u32 j = base + lane;
                        bool close = j < end;
                        int4 q = a.fixed[close ? j : begin];
#ifdef IMAGES
                        q.x += shift.x, q.y += shift.y, q.z += shift.z;
#endif
#ifdef FOLDED
                        {
                            Point pj;
                            for (u32 axis = 0; axis < 3; axis++)
                                pj.x[axis] = axis_of(side_of(a.held_x, s, r.parity, 3), s, axis)[close ? j : begin];
                            u32 cell_j[3], octant_j, part_j;
                            key_of(s, pj, cell_j, &octant_j, &part_j);
                            close &= cell_number(cell_j) == wanted_cell;
                        }
#endif
                        const float gx = gap(q.x, from.x, low[0], high[0]) * s.scale[0];
                        const float gy = gap(q.y, from.y, low[1], high[1]) * s.scale[1];
                        const float gz = gap(q.z, from.z, low[2], high[2]) * s.scale[2];
                        close &= gx * gx + gy * gy + gz * gz <= s.reach;
                        const u32 bits = __ballot_sync(~0u, close);
                        if (close) {
                            const u32 place = __popc(bits & ((1u << lane) - 1));
                            near[warp][place] = q;
#ifdef IMAGES
                            near_entry[warp][place] = (Entry)code << INDEX_BITS | j;
#else
                            near_entry[warp][place] = j;
#endif
                        }
                        __syncwarp();
                        const u32 found = __popc(bits);
                        // Bits of candidates: certainly neighbors, and those that rounding could decide.
                        u32 in = 0, doubt = 0;
#pragma unroll 4
                        for (u32 c = 0; c < found; c++) {
                            const int4 other = near[warp][c];
                            const float dx = (float)(own.x - other.x) * s.scale[0];
                            const float dy = (float)(own.y - other.y) * s.scale[1];
                            const float dz = (float)(own.z - other.z) * s.scale[2];
                            const float r2 = dx * dx + dy * dy + dz * dz;
#if TYPES > 1
                            const Limit limit = a.limits[own.w * TYPES + other.w];
#endif
                            in |= (u32)(r2 < limit.inner) << c;
                            doubt |= (u32)(r2 <= limit.outer) << c;
                        }
                        if (!active) in = doubt = 0;
                        u32 itself = ~0u;
                        if (own_image && i - base < 32) itself = ~((bits >> (i - base) & 1) << __popc(bits & ((1u << (i - base)) - 1)));
                        in &= itself;
                        doubt &= itself & ~in;
                        while (doubt) {
                            const u32 c = __ffs(doubt) - 1;
                            doubt &= doubt - 1;
                            const u32 k = place_of(near_entry[warp][c]);
#if TYPES > 1
                            const Limit limit = a.limits[own.w * TYPES + near[warp][c].w];
#endif
                            in |= (u32)is_neighbor(a, s, r, i, k, ix, iy, iz, limit.squared) << c;
                        }
                        while (in) {
                            const u32 c = __ffs(in) - 1;
                            in &= in - 1;
                            add_entry(a, s, i, row, near_entry[warp][c]);
                        }
                        __syncwarp();
                    }
                }
            }
            if (active) {
                close_row(a, s, i, row);
                a.neighbors[i] = row.count;
                entries += row.count;
                most = row.count > most ? row.count : most;
            }
        }
    }
    for (u32 d = 16; d > 0; d >>= 1) entries += __shfl_xor_sync(~0u, entries, d);
    if (lane == 0 && (entries | tests)) {
        atomicAdd(&a.control->entries, entries);
        atomicAdd(&a.control->tests, tests);
    }
    if (most > s.capacity) atomicMax(&a.control->wanted, most);
}
