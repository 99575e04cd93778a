// Pair forces: LANES threads a particle add up its row, always in the same order.

// Adds one pair to the sums of a row.
template <bool SUMS>
__device__ __forceinline__ void add_pair(const Arrays& a, const Scene& s, const Slot& own, Slot q, u32 code, bool there, real unit_squared, const real* one, real f[3], real sums[TOTALS]) {
    real d[3];
#ifdef FIXED
#ifdef IMAGES
    const int4 shift = a.fixed_shifts[code];
    q.x += shift.x, q.y += shift.y, q.z += shift.z;
#endif
    d[0] = (real)(own.x - q.x), d[1] = (real)(own.y - q.y), d[2] = (real)(own.z - q.z);
#ifdef SCALED
    for (u32 axis = 0; axis < 3; axis++) d[axis] *= s.scale[axis];
#endif
    real r2 = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) * unit_squared;
#else
#ifdef IMAGES
    const Slot at = q;
    if (code != s.no_image) {
        const Slot shift = a.shifts[code];
        q.x += shift.x, q.y += shift.y, q.z += shift.z;
    }
#endif
    d[0] = own.x - q.x, d[1] = own.y - q.y, d[2] = own.z - q.z;
    real r2 = __dadd_rn(__dadd_rn(__dmul_rn(d[0], d[0]), __dmul_rn(d[1], d[1])), __dmul_rn(d[2], d[2]));
#endif
#if TYPES > 1
    const real* p = a.coefficients + ((u32)own.w * TYPES + (u32)q.w) * NUMBERS;
#else
    const real* p = one;
#endif
    bool in = r2 < p[0];
#if !defined(FIXED) && PERIODIC
    // Across a side, rounding must decide for both rows of a pair alike.
    double tied;
    is_tied(r2, p[0], s.tie_band, &tied);
    if (code != s.no_image && tied != 0.0) {
        const int4 n = a.images[code];
        const double image[3] = {(double)n.x, (double)n.y, (double)n.z};
        const double xi[3] = {own.x, own.y, own.z}, xj[3] = {at.x, at.y, at.z};
        double exact;
        tied_squared_distance(xi, xj, image, s, &exact);
        in = exact < p[0];
    }
#endif
    in &= there;
#ifndef FIXED
    if (!in) return;
#endif
    real force, energy;
    if (SUMS) pair_both(r2, p, &force, &energy);
    else pair_force(r2, p, &force);
    force = in ? force : (real)0;
    for (u32 axis = 0; axis < 3; axis++) f[axis] += force * d[axis];
    if (SUMS) {
        sums[0] += in ? energy : (real)0;
        sums[1] += force * d[0] * d[0], sums[2] += force * d[1] * d[1], sums[3] += force * d[2] * d[2];
        sums[4] += force * d[0] * d[1], sums[5] += force * d[0] * d[2], sums[6] += force * d[1] * d[2];
    }
}

// Entries that are read once a step: they are not to drive out of the caches what is read again and again.
__device__ __forceinline__ Chunk stream(const Chunk* from) {
    union {
        Chunk chunk;
        uint4 words[sizeof(Chunk) / 16];
    } to;
    for (u32 k = 0; k < sizeof(Chunk) / 16; k++) to.words[k] = __ldcs((const uint4*)from + k);
    return to.chunk;
}

// What is done with the force on a particle.
enum Then {
    KEEP, // f, energy and virial
    STAY, // f
    MOVE, // the second half of this step and the first half of the next at once, where no one wants to see what lies between
};

// Reads slots of this step and the list; with KEEP writes one set of energy and virial a block. With MOVE writes x, v, and
// slots of the next step, and f only where it is no number: such a particle stays, to be looked at. Returns what came to any
// of its particles: bits of MARK_.
template <Then THEN> __device__ __forceinline__ u32 pair_forces(const Arrays& a, const Scene& s, const Run& r) {
    const u32 lane = threadIdx.x % LANES;
    const bool SUMS = THEN == KEEP;
    real one[NUMBERS];
    for (u32 k = 0; k < NUMBERS; k++) one[k] = TYPES > 1 ? (real)0 : a.coefficients[k];
    const real unit_squared = pinned((real)s.unit_squared), force_unit = pinned((real)s.force_unit);
    const Pace pace = pace_of(s);
    const Slot* slots = slots_of(a, s, r.step);
    Slot* next = slots_of(a, s, r.step + 1);
    double totals[TOTALS] = {0};
    u32 marks = 0;
    for (u32 i = THREAD / LANES; i < r.n; i += THREADS / LANES) {
        const Slot own = slots[i];
        const u32 count = a.neighbors[i];
        real f[3] = {0, 0, 0}, sums[TOTALS] = {0};
        const Chunk* row = a.list + lane * s.pitch + i;
        // The next entries are on their way while these are worked out.
        Chunk coming = stream(row);
        asm volatile("// pair loop");
        for (u32 first = lane * CHUNK; first < count; first += LANES * CHUNK) {
            const Chunk chunk = coming;
            row += s.pitch * LANES;
            if (first + LANES * CHUNK < count) coming = stream(row);
#pragma unroll
            for (u32 m = 0; m < CHUNK; m++) {
#ifdef FIXED
                // Beyond the end of a row stand entries that are no neighbors, but places of particles: worked out for nothing
                // they cost less than a branch.
#else
                if (first + m >= count) break;
#endif
                const Entry entry = chunk.entry[m];
#ifdef IMAGES
                const u32 code = (u32)(entry >> INDEX_BITS);
#else
                const u32 code = 0;
#endif
                add_pair<SUMS>(a, s, own, slots[place_of(entry)], code, first + m < count, unit_squared, one, f, sums);
            }
        }
        asm volatile("// end of pair loop");
        const u32 shift = (threadIdx.x & 31) & ~(LANES - 1);
        const u32 group = (LANES == 32 ? ~0u : ((1u << (LANES & 31)) - 1)) << shift;
        for (u32 d = LANES / 2; d > 0; d >>= 1)
            for (u32 axis = 0; axis < 3; axis++) f[axis] += __shfl_xor_sync(group, f[axis], d);
        if (lane == 0) {
            store force[3];
            bool broken = false;
            for (u32 axis = 0; axis < 3; axis++) f[axis] *= force_unit;
#ifdef FORCES
            add_forces(a, s, r, i, f);
#endif
            for (u32 axis = 0; axis < 3; axis++) {
                broken |= !isfinite(f[axis]);
                force[axis] = (store)f[axis];
            }
            if (THEN != MOVE || broken)
                for (u32 axis = 0; axis < 3; axis++) axis_of(a.f, s, axis)[i] = (real)force[axis];
            if (broken) marks |= MARK_FORCE;
            else if (THEN == MOVE) marks |= move_particle<true, true>(a, s, r, pace, i, force, next);
        }
        if (SUMS) {
            for (u32 k = 0; k < TOTALS; k++) totals[k] += (double)sums[k];
        }
    }
    if (SUMS) {
        __shared__ double scratch[32];
        for (u32 k = 0; k < TOTALS; k++) {
            const double total = sum_block(totals[k], scratch);
            if (threadIdx.x == 0) a.block_sums[blockIdx.x * TOTALS + k] = total;
        }
    }
    return marks;
}
