// The list: a warp for a group of particles of one octant, which have the same candidates. The runs of sorted particles that
// hold them are laid end to end; of 32 candidates side by side those out of reach of the whole group are dropped, and the
// rest is tested 32 at a time, a thread a candidate, against one particle of the group after the other. Neighbors found
// together are written together.
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
    double held;
    hold(xi, xj, image, s, limit, &held);
    return held != 0.0;
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

// Distance of a coordinate from an interval.
__device__ __forceinline__ float gap(float x, float low, float high) { return fmaxf(fmaxf(low - x, x - high), 0.0f); }

// Bits of a particle's type where a run stands above it.
#define KIND_BITS 16

// A warp's candidates that wait to be tested: coordinates in fixed-point units of the coarsest axis, relative to the first
// particle of the group, with type and run; and their entries.
struct Waiting {
    float4 own[32];
    float4 at[64];
    Entry entry[64];
#if PERIODIC
    int image[32][3]; // by run
#endif
};

__device__ __forceinline__ float4 relative(const Scene& s, const int4& q, const int4& from, u32 kind_and_run) {
    return make_float4((float)(q.x - from.x) * s.scale[0], (float)(q.y - from.y) * s.scale[1], (float)(q.z - from.z) * s.scale[2],
                       __uint_as_float(kind_and_run));
}

// Tests the first 32 candidates that wait against m particles from first_i on. Lane i holds the length of row i. Where
// rounding in f32 could decide, nothing is counted and the answer is true: once more, EXACT.
template <bool EXACT>
__device__ __forceinline__ bool test_candidates(const Arrays& a, const Scene& s, const Run& r, const Waiting& w, u32 lane, u32 found, u32 first_i, u32 m, Limit limit, u32& count) {
    const u32 below = (1u << lane) - 1;
    // Where no candidate waits, one that is far away.
    const float4 c = lane < found ? w.at[lane] : make_float4(3e38f, 0, 0, 0);
    const Entry entry = w.entry[lane];
#if TYPES > 1
    const Limit* limits = a.limits + (__float_as_uint(c.w) & ((1u << KIND_BITS) - 1)) * TYPES;
#endif
    Entry self = first_i;
#ifdef IMAGES
    self |= (Entry)s.no_image << INDEX_BITS;
#endif
    // Chunks of a row stand a pitch apart.
    const Stride pitch = (Stride)s.pitch * (Stride)sizeof(Chunk);
    char* rows = (char*)(a.list + first_i);
    bool doubt = false;
    u32 mine = 0;
#pragma unroll (EXACT ? 1 : 4)
    for (u32 i = 0; i < m; i++) {
        const float4 o = w.own[i];
        const float dx = o.x - c.x, dy = o.y - c.y, dz = o.z - c.z;
        const float r2 = dx * dx + dy * dy + dz * dz;
#if TYPES > 1
        limit = limits[__float_as_uint(o.w)];
#endif
        bool in = r2 <= limit.outer && entry != self + i;
        const bool unsure = in && !(r2 < limit.inner);
        doubt |= unsure;
        if (EXACT && unsure) {
            int n[3] = {0, 0, 0};
#if PERIODIC
            for (u32 axis = 0; axis < 3; axis++) n[axis] = w.image[__float_as_uint(c.w) >> KIND_BITS][axis];
#endif
            in = is_neighbor(a, s, r, first_i + i, place_of(entry), n[0], n[1], n[2], limit.squared);
        }
        const u32 bits = __ballot_sync(~0u, in);
        const u32 k = __shfl_sync(~0u, count, i) + __popc(bits & below);
        if (in && k < s.capacity) ((Entry*)(rows + (u64)(k / CHUNK) * pitch + i * sizeof(Chunk)))[k % CHUNK] = entry;
        if (lane == i) mine = bits;
    }
    const bool again = !EXACT && __any_sync(~0u, doubt);
    if (!again) count += __popc(mine);
    return again;
}

// Rows of m particles from first_i on, all in one octant of a cell.
__device__ __forceinline__ void list_group(const Arrays& a, const Scene& s, const Run& r, Waiting& w, const u32 cell[3], u32 octant, u32 lane, u32 first_i, u32 m, u64& entries, u64& tests, u32& most) {
    const int4 own = a.fixed[first_i + (lane < m ? lane : 0)];
    const int4 from = make_int4(__shfl_sync(~0u, own.x, 0), __shfl_sync(~0u, own.y, 0), __shfl_sync(~0u, own.z, 0), 0);
    const float4 at = relative(s, own, from, (u32)own.w);
    float low[3] = {at.x, at.y, at.z}, high[3];
    for (u32 axis = 0; axis < 3; axis++) {
        high[axis] = low[axis];
        for (u32 d = 16; d > 0; d >>= 1) {
            low[axis] = fminf(low[axis], __shfl_xor_sync(~0u, low[axis], d));
            high[axis] = fmaxf(high[axis], __shfl_xor_sync(~0u, high[axis], d));
        }
    }
    w.own[lane] = at;
    const Limit limit = a.limits[0];
    const u32 last = a.visit_starts[octant + 1];
    u32 count = 0;
    for (u32 first = a.visit_starts[octant]; first < last; first += 32) {
        // A run a lane: where it begins, how long it is, and what its particles are to be shifted by.
        u32 begin = 0, length = 0;
#ifdef IMAGES
        u32 code = 0;
#endif
#ifdef FOLDED
        u64 wanted_cell = 0;
#endif
        if (first + lane < last) {
            const int4 visit = a.visits[first + lane];
            i64 cx = (i64)cell[0] + visit.x, cy = (i64)cell[1] + visit.y, cz = (i64)cell[2] + visit.z;
            int ix = 0, iy = 0, iz = 0;
            if (enter(s, 0, cx, ix) && enter(s, 1, cy, iy) && enter(s, 2, cz, iz)) {
                const u32 bucket = table_of(s, (u32)cx, (u32)cy, (u32)cz) * OCTANTS + (u32)visit.w % OCTANTS;
                begin = a.starts[bucket];
                length = a.starts[bucket + (u32)visit.w / OCTANTS] - begin;
            }
#if PERIODIC
            w.image[lane][0] = ix, w.image[lane][1] = iy, w.image[lane][2] = iz;
#endif
#ifdef IMAGES
            code = ((iz + s.images[2]) * (2 * s.images[1] + 1) + iy + s.images[1]) * (2 * s.images[0] + 1) + ix + s.images[0];
#endif
#ifdef FOLDED
            const u32 wanted[3] = {(u32)cx, (u32)cy, (u32)cz};
            wanted_cell = cell_number(wanted);
#endif
        }
        u32 upto = length;
        for (u32 d = 1; d < 32; d <<= 1) {
            const u32 before = __shfl_up_sync(~0u, upto, d);
            if (lane >= d) upto += before;
        }
        const u32 all = __shfl_sync(~0u, upto, 31), offset = begin - (upto - length);
        tests += (u64)all * m;
        u32 waiting = 0;
        __syncwarp();
        for (u32 base = 0; base < all; base += 32) {
            bool close = base + lane < all;
            // Beyond the end the last candidate stands in.
            const u32 t = close ? base + lane : all - 1;
            u32 run = 0;
            for (u32 d = 16; d > 0; d >>= 1)
                if (__shfl_sync(~0u, upto, run + d - 1) <= t) run += d;
            const u32 j = t + __shfl_sync(~0u, offset, run);
            int4 q = a.fixed[j];
#ifdef IMAGES
            const u32 image = __shfl_sync(~0u, code, run);
            const int4 shift = a.fixed_shifts[image];
            q.x += shift.x, q.y += shift.y, q.z += shift.z;
            const Entry entry = (Entry)image << INDEX_BITS | j;
#else
            const Entry entry = j;
#endif
#ifdef FOLDED
            {
                const u64 wanted = __shfl_sync(~0u, wanted_cell, run);
                Point p;
                for (u32 axis = 0; axis < 3; axis++) p.x[axis] = axis_of(side_of(a.held_x, s, r.parity, 3), s, axis)[j];
                u32 cell_j[3], octant_j, part_j;
                key_of(s, p, cell_j, &octant_j, &part_j);
                close &= cell_number(cell_j) == wanted;
            }
#endif
            const float4 c = relative(s, q, from, (u32)q.w | run << KIND_BITS);
            const float gx = gap(c.x, low[0], high[0]), gy = gap(c.y, low[1], high[1]), gz = gap(c.z, low[2], high[2]);
            close &= gx * gx + gy * gy + gz * gz <= s.reach;
            const u32 bits = __ballot_sync(~0u, close);
            if (close) {
                const u32 place = waiting + __popc(bits & ((1u << lane) - 1));
                w.at[place] = c;
                w.entry[place] = entry;
            }
            waiting += __popc(bits);
            __syncwarp();
            // The last ones of these runs are tested however few they are: images are known by run.
            while (waiting >= 32 || (waiting > 0 && base + 32 >= all)) {
                const u32 found = waiting < 32 ? waiting : 32;
                if (test_candidates<false>(a, s, r, w, lane, found, first_i, m, limit, count))
                    test_candidates<true>(a, s, r, w, lane, found, first_i, m, limit, count);
                waiting -= found;
                const float4 rest = w.at[32 + lane];
                const Entry rest_entry = w.entry[32 + lane];
                __syncwarp();
                w.at[lane] = rest;
                w.entry[lane] = rest_entry;
                __syncwarp();
            }
        }
    }
    if (lane < m) {
        a.neighbors[first_i + lane] = count;
        entries += count;
        most = count > most ? count : most;
    }
}

__device__ void build_list(const Arrays& a, const Scene& s, const Run& r) {
    __shared__ Waiting waiting[BLOCK / 32];
    const Quanta quanta = quanta_of(s);
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
        pack(a, s, r, quanta, k, x, kind_of(a, s, r, k));
    }
    u32 lane;
    // Once: the compiler would ask for it over and over to save a register.
    asm volatile("mov.u32 %0, %%laneid;" : "=r"(lane));
    u64 entries = 0, tests = 0;
    u32 most = 0;
    // Octants differ in what they hold: after its first one a warp takes the next that nobody has.
    const u32 warps = THREADS >> 5, tasks = s.buckets * SLICES;
    for (u32 task = THREAD >> 5; task < tasks;) {
        const u32 bucket = task / SLICES, end = a.starts[bucket + 1];
        for (u32 group = a.starts[bucket] + task % SLICES * GROUP; group < end; group += SLICES * GROUP) {
            const u32 group_end = group + GROUP < end ? group + GROUP : end;
            u32 first = group;
            while (first < group_end) {
                const bool there = first + lane < group_end;
                Point p;
                for (u32 axis = 0; axis < 3; axis++)
                    p.x[axis] = axis_of(side_of(a.held_x, s, r.parity, 3), s, axis)[there ? first + lane : first];
                u32 cell[3], octant, part;
                key_of(s, p, cell, &octant, &part);
                u32 m = group_end - first;
#ifdef FOLDED
                // Cells may share a place in the table: those of the first one's cell.
                const u64 number = cell_number(cell), wanted = __shfl_sync(~0u, number, 0);
                m = __popc(__ballot_sync(~0u, there && number == wanted));
                for (u32 axis = 0; axis < 3; axis++) cell[axis] = __shfl_sync(~0u, cell[axis], 0);
#endif
                list_group(a, s, r, waiting[threadIdx.x >> 5], cell, octant, lane, first, m, entries, tests, most);
                first += m;
            }
        }
        if (tasks <= warps) break;
        if (lane == 0) task = warps + atomicAdd(&a.control->taken, 1u);
        task = __shfl_sync(~0u, task, 0);
    }
    for (u32 d = 16; d > 0; d >>= 1) entries += __shfl_xor_sync(~0u, entries, d);
    if (lane == 0 && (entries | tests)) {
        atomicAdd(&a.control->entries, entries);
        atomicAdd(&a.control->tests, tests);
    }
    if (most > s.capacity) atomicMax(&a.control->wanted, most);
}
