// The list: a warp for a group of particles of one octant, which have the same candidates. The runs of sorted particles that
// hold them are laid end to end; of 32 candidates side by side those out of reach of the whole group are dropped, and 32 that
// are left are tested against all of it at once.

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

// A candidate as it is fetched.
struct Candidate {
    int4 q;
    Stored entry;
    bool there;
};

// The squared neighbor cutoff of two types, in units of the matrix products.
__device__ __forceinline__ float squared_cutoff(const Arrays& a, const Scene& s, u32 kind, u32 with) {
    const Limit limit = a.limits[kind * TYPES + with];
    return 0.5f * (limit.inner + limit.outer) * s.tensor_square;
}

// Rows of m particles from first_i on, all in one octant of a cell.
__device__ __forceinline__ void list_group(const Arrays& a, const Scene& s, const Run& r, Bench& w, const u32 cell[3], u32 bucket, u32 lane, u32 first_i, u32 m, u64& entries, u64& tests, u32& most) {
    Group g;
    g.first_i = first_i, g.m = m, g.lane = lane, g.mine = row_of(lane), g.fill = 0, g.done = 0;
    // Products are of coordinates relative to the middle of the group, in units that have the largest cutoff at
    // TENSOR_REACH; nothing lies further than half a width from the middle.
    const float unit[3] = {s.tensor_unit[0], s.tensor_unit[1], s.tensor_unit[2]};
    int4 middle;
    float width[3], reach;
    {
        const int4 own = a.fixed[first_i + (lane < m ? lane : 0)];
#ifdef SHORT
        if (lane < m) a.homes[first_i + lane] = bucket;
#endif
        const int from[3] = {__shfl_sync(~0u, own.x, 0), __shfl_sync(~0u, own.y, 0), __shfl_sync(~0u, own.z, 0)};
        const int at[3] = {own.x - from[0], own.y - from[1], own.z - from[2]};
        int center[3];
        for (u32 axis = 0; axis < 3; axis++) {
            const int low = least_of(at[axis]), high = -least_of(-at[axis]);
            const u32 half = (u32)(high - low) / 2;
            center[axis] = from[axis] + low + (int)half;
            width[axis] = (float)(half + 1) * unit[axis];
        }
        middle = make_int4(center[0], center[1], center[2], 0);
        const float3 x = relative(own, middle, unit);
        const float furthest = (float)TENSOR_REACH + sqrtf(width[0] * width[0] + width[1] * width[1] + width[2] * width[2]);
        const float band = s.tensor_band + TENSOR_ERROR * furthest * furthest;
        reach = s.tensor_limit + band;
        // Halves end at 65504.
        g.band = furthest < 128.0f ? band : 3e38f;
#if defined(CUTOFFS) && !defined(BY_TYPE) && !defined(TWO_CUTOFFS)
        g.band = 3e38f;
#endif
        float cutoff = s.tensor_limit, less = 0;
#ifdef TWO_CUTOFFS
        cutoff = squared_cutoff(a, s, own.w, 0);
        less = cutoff - squared_cutoff(a, s, own.w, 1);
#endif
#ifdef BY_TYPE
        for (u32 t = 0; t < TILES; t++)
            for (u32 k = 0; k < 4; k++) {
                const u32 row = t * TILE + k % 2 * 8 + (lane >> 2), with = (lane & 3) + k / 2 * 4;
                const u32 kind = (u32)__shfl_sync(~0u, own.w, row);
                g.cutoffs[t][k] = halves_of(s.tensor_limit - squared_cutoff(a, s, kind, with < TYPES ? with : 0));
            }
#endif
        __syncwarp();
        write_particle(w, lane, x, lane < m, cutoff, less);
        __syncwarp();
        for (u32 t = 0; t < TILES; t++) {
            const u32 row = t * TILE + (lane & 15);
            load_matrices(lane & 16 ? &w.right[row] : &w.left[row], g.particles[t]);
        }
        __syncwarp();
    }
    const u32 visits = visits_of(a, s, r, bucket % OCTANTS, first_i + (lane < m ? lane : 0)), last = a.visit_starts[visits + 1];
    u32 staged = 0, tested = 0, own = 1u << 31;
    for (u32 first = a.visit_starts[visits]; first < last; first += 32) {
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
#ifdef IMAGES
            code = ((iz + s.images[2]) * (2 * s.images[1] + 1) + iy + s.images[1]) * (2 * s.images[0] + 1) + ix + s.images[0];
#endif
#ifdef FOLDED
            const u32 wanted[3] = {(u32)cx, (u32)cy, (u32)cz};
            wanted_cell = cell_number(wanted);
#endif
        }
#ifdef SHORT
        // Where an entry cannot name all places of a run nothing is listed: the host begins anew with longer ones.
        if (__any_sync(~0u, length > 1u << PLACE_BITS)) {
            if (lane == 0) atomicOr(&a.control->sort_trouble, TROUBLE_RUNS);
            length = 0;
        }
#endif
        // Runs that hold something to the front.
        const u32 filled = __ballot_sync(~0u, length > 0), below = (1u << lane) - 1;
        w.order[length > 0 ? __popc(filled & below) : __popc(filled) + __popc(~filled & below)] = lane;
        __syncwarp();
        const u32 from = w.order[lane];
        begin = __shfl_sync(~0u, begin, from);
        length = __shfl_sync(~0u, length, from);
#ifdef IMAGES
        code = __shfl_sync(~0u, code, from);
#endif
#ifdef FOLDED
        wanted_cell = __shfl_sync(~0u, wanted_cell, from);
#endif
        u32 upto = length;
        for (u32 d = 1; d < 32; d <<= 1) {
            const u32 before = __shfl_up_sync(~0u, upto, d);
            if (lane >= d) upto += before;
        }
        const u32 all = __shfl_sync(~0u, upto, 31), offset = begin - (upto - length);
        tests += (u64)all * m;
        // The first of the group among these candidates, and what makes entries of them.
#ifdef IMAGES
        bool home = code == s.no_image;
        const Entry first_entry = (Entry)code << INDEX_BITS | begin;
#else
        bool home = true;
        const Entry first_entry = begin;
#endif
#ifdef FOLDED
        home &= wanted_cell == cell_number(cell);
#endif
        const u32 at_home = __ballot_sync(~0u, home && first_i - begin < length);
        u32 own_at = 1u << 31;
#ifdef SHORT
        const Stored shorter = (from << PLACE_BITS) - (upto - length);
        if (length > 0) runs_of(a, bucket)[from] = first_entry - (from << PLACE_BITS);
#endif
        if (at_home) {
            const u32 run = __ffs(at_home) - 1;
            own_at = first_i - __shfl_sync(~0u, offset, run);
#ifdef SHORT
            if (lane == run) w.self = shorter + own_at;
#else
            if (lane == run) w.self = first_entry + first_i - begin;
#endif
        }
        const auto fetch = [&](u32 base) {
            Candidate c;
            c.there = base + lane < all;
            // Beyond the end the last candidate stands in.
            const u32 t = c.there ? base + lane : all - 1;
            // Runs that end before this candidate: before the first of these 32, and in between.
            const u32 end = upto - base;
            const u32 ends = bits_of_all(end - 1 < 31 ? 1u << end : 0);
            const u32 run = __popc(__ballot_sync(~0u, upto <= base)) + __popc(ends & ((2u << (t - base)) - 1));
            const u32 j = t + __shfl_sync(~0u, offset, run);
            c.q = a.fixed[j];
#ifdef SHORT
            c.entry = __shfl_sync(~0u, (u32)shorter, run) + t;
#else
            c.entry = j;
#endif
#ifdef IMAGES
            const u32 image = __shfl_sync(~0u, code, run);
            const int4 shift = a.fixed_shifts[image];
            c.q.x += shift.x, c.q.y += shift.y, c.q.z += shift.z;
#ifndef SHORT
            c.entry |= (Entry)image << INDEX_BITS;
#endif
#endif
#ifdef FOLDED
            const u64 wanted = __shfl_sync(~0u, wanted_cell, run);
            Point p;
            for (u32 axis = 0; axis < 3; axis++) p.x[axis] = axis_of(side_of(a.held_x, s, r.parity, 3), s, axis)[j];
            u32 cell_j[3], octant_j, part_j;
            key_of(s, p, cell_j, &octant_j, &part_j);
            c.there &= cell_number(cell_j) == wanted;
#endif
            return c;
        };
        Candidate coming = {};
        if (all > 0) coming = fetch(0);
        const bool final = first + 32 >= last;
        u32 base = 0;
#pragma unroll 1
        do {
            const Candidate c = coming;
            if (base + 32 < all) coming = fetch(base + 32);
            const float3 x = relative(c.q, middle, unit);
            const float gx = fmaxf(fabsf(x.x) - width[0], 0.0f), gy = fmaxf(fabsf(x.y) - width[1], 0.0f), gz = fmaxf(fabsf(x.z) - width[2], 0.0f);
            const bool close = c.there && gx * gx + gy * gy + gz * gz <= reach;
            const u32 bits = __ballot_sync(~0u, close);
            if (own_at - base < 32) own = staged + __popc(bits & ((1u << (own_at - base)) - 1));
            if (close) {
                const u32 place = (staged + __popc(bits & below)) % 64;
                write_candidate(w, place, x, c.q.w);
#ifdef BY_TYPE
                w.kind[place] = (unsigned char)c.q.w;
#endif
                w.entry[place] = c.entry;
            }
            staged += __popc(bits);
            base += 32;
            // Whole batches, and at the end what is left.
            const u32 enough = final && base >= all ? 1 : 32;
#pragma unroll 1
            while (staged - tested >= enough) {
                const u32 found = staged - tested < 32 ? staged - tested : 32;
                __syncwarp();
                test_candidates(a, s, r, w, g, tested % 64, found, own - tested);
                tested += found;
                __syncwarp();
            }
        } while (base < all);
    }
    write_chunks<true>(a, s, w, g);
    if (g.mine < m) {
        const u32 count = g.done * CHUNK + g.fill;
        a.neighbors[first_i + g.mine] = count;
        entries += count;
        most = count > most ? count : most;
    }
    __syncwarp();
}

__device__ void build_list(const Arrays& a, const Scene& s, const Run& r) {
    __shared__ Bench benches[LIST_BLOCK / 32];
    const Quanta quanta = quanta_of(s);
    Slot* slots = slots_of(a, s, r.step);
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
        pack(a, s, r, quanta, k, x, kind_of(a, s, r, k), slots);
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
                u32 m = group_end - first;
#ifdef FOLDED
                // Cells may share a place in the table: those of the first one's cell.
                const bool there = first + lane < group_end;
                Point p;
                for (u32 axis = 0; axis < 3; axis++)
                    p.x[axis] = axis_of(side_of(a.held_x, s, r.parity, 3), s, axis)[there ? first + lane : first];
                u32 cell[3], octant, part;
                key_of(s, p, cell, &octant, &part);
                const u64 number = cell_number(cell), wanted = __shfl_sync(~0u, number, 0);
                m = __popc(__ballot_sync(~0u, there && number == wanted));
                for (u32 axis = 0; axis < 3; axis++) cell[axis] = __shfl_sync(~0u, cell[axis], 0);
#else
                u32 cell[3];
                cell_at(s, bucket / OCTANTS, cell);
#endif
                list_group(a, s, r, benches[threadIdx.x >> 5], cell, bucket, lane, first, m, entries, tests, most);
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
