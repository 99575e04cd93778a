// Pair forces: LANES threads a particle add up its row, always in the same order.

// What is added up beside forces.
enum Adds {
    NOTHING,
    PRESSURE, // energy and the trace of the virial, which is what the scalar pressure takes: less than half the work of
    ALL,      // all TOTALS
};

// Types whose numbers with the particle's own a thread holds in registers: with more of them, or in double precision, they are
// looked up for each pair.
#if TYPES == 1 || TYPES == 2 && defined(FIXED)
#define HELD_TYPES TYPES
#else
#define HELD_TYPES 0
#endif

// Adds one pair to the sums of a row; returns whether it is near enough for the inner list.
template <Adds ADDS>
__device__ __forceinline__ bool add_pair(const Arrays& a, const Scene& s, const Slot& own, Slot q, u32 code, bool there, real unit_squared, real work_unit, const real* mine, real f[3], real sums[TOTALS]) {
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
    const real squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    real r2 = squared * unit_squared;
#else
#ifdef IMAGES
    const Slot at = q;
    if (code != s.no_image) {
        const Slot shift = a.shifts[code];
        q.x += shift.x, q.y += shift.y, q.z += shift.z;
    }
#endif
    d[0] = own.x - q.x, d[1] = own.y - q.y, d[2] = own.z - q.z;
    const real squared = __dadd_rn(__dadd_rn(__dmul_rn(d[0], d[0]), __dmul_rn(d[1], d[1])), __dmul_rn(d[2], d[2]));
    const real r2 = squared;
#endif
#if HELD_TYPES == 1
    const real* p = mine;
#elif HELD_TYPES == 2
    real p[NUMBERS];
    for (u32 k = 0; k < NUMBERS; k++) p[k] = q.w != 0 ? mine[NUMBERS + k] : mine[k];
#else
    const real* p = a.coefficients + ((u32)own.w * TYPES + (u32)q.w) * NUMBERS;
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
#ifdef INNER
    const bool near = there & (r2 < p[NUMBERS - 1]);
#else
    const bool near = false;
#endif
#ifndef FIXED
    if (!in) return near;
#endif
    real force, energy;
    if (ADDS != NOTHING) pair_both(r2, p, &force, &energy);
    else pair_force(r2, p, &force);
    // What is added up beside forces must not show in them: each component takes one operation, whatever use the product has.
    if (ADDS == NOTHING) {
        // Three instructions under a condition, and none that makes a zero; not a branch that the force is worked out behind.
        force = pinned(force);
        if (in)
            for (u32 axis = 0; axis < 3; axis++) f[axis] = fma(force, d[axis], f[axis]);
    } else {
        force = in ? force : (real)0;
        for (u32 axis = 0; axis < 3; axis++) f[axis] = fma(force, d[axis], f[axis]);
        sums[0] += in ? energy : (real)0;
#ifdef FIXED
        // In squares of a quantum a virial is no f32 where the force still is one.
        force *= work_unit;
#endif
        sums[1] = fma(force, squared, sums[1]);
    }
    if (ADDS == ALL) {
        sums[2] += force * d[0] * d[0], sums[3] += force * d[1] * d[1], sums[4] += force * d[2] * d[2];
        sums[5] += force * d[0] * d[1], sums[6] += force * d[0] * d[2], sums[7] += force * d[1] * d[2];
    }
    return near;
}

// Entries of the list that are looked up and read before any of them is worked out.
#define BATCH 4
#define TEXT_OF(x) #x
#define TEXT(x) TEXT_OF(x)

// What is done with the force on a particle.
enum Then {
    KEEP,   // f, energy and virial
    STAY,   // f
    RECORD, // energy, virial or its trace, kinetic sums, and as MOVE
    KICK,   // f, the second half of this step, and m v^2 of the groups of thermostats
    MOVE,   // the second half of this step and the first half of the next at once, where no one wants to see what lies between
};

// Reads slots of this step and a list. With KEEP and RECORD adds to the sums of this thread: TOTALS of pairs, of which RECORD
// has all where TENSOR is set and PRESSURE_TOTALS elsewhere; with RECORD also KINETIC of its particles. With MOVE and RECORD
// writes x, v, and slots of the next step, and f only where it is no number: such a particle stays, to be looked at. Returns
// what came to any of its particles: bits of MARK_.
template <Then THEN, From FROM = LIST> __device__ __forceinline__ u32 pair_forces(const Arrays& a, const Scene& s, const Run& r, double* totals = nullptr) {
    const u32 lane = threadIdx.x % LANES;
    const bool MOVES = THEN == MOVE || THEN == RECORD;
#ifdef TENSOR
    const Adds RECORDED = ALL;
#else
    const Adds RECORDED = PRESSURE;
#endif
    const Adds ADDS = THEN == KEEP ? ALL : THEN == RECORD ? RECORDED : NOTHING;
    real mine[2 * NUMBERS] = {};
    if (HELD_TYPES == 1)
        for (u32 k = 0; k < NUMBERS; k++) mine[k] = a.coefficients[k];
    const real unit_squared = pinned((real)s.unit_squared), force_unit = pinned((real)s.force_unit);
    real work_unit = 1;
#ifdef FIXED
    if (ADDS != NOTHING) work_unit = pinned((real)s.work_unit);
#endif
    const Pace pace = pace_of(s);
    const Slot* slots = slots_of(a, s, r.step);
    Slot* next = slots_of(a, s, r.step + 1);
    const u32 runs = own_runs();
    const u64 policy = lasting();
    u32 marks = 0;
    for (u32 i = THREAD / LANES; i < r.n; i += THREADS / LANES) {
        const Slot own = slots[i];
        // A thread has every LANES-th chunk of a row of the list, and a part of the inner list that is its own.
        const u32 count = FROM == NEAR ? kept_by(a, s, lane)[i] : a.neighbors[i];
        const u32 begin = FROM == NEAR ? 0 : lane * CHUNK, stride = FROM == NEAR ? CHUNK : LANES * CHUNK;
        if (HELD_TYPES == 2)
            for (u32 k = 0; k < 2 * NUMBERS; k++) mine[k] = a.coefficients[(u32)own.w * 2 * NUMBERS + k];
        real f[3] = {0, 0, 0}, sums[TOTALS] = {0};
        const Chunk* row = (FROM == NEAR ? inner_of(a) : a.list) + lane * s.pitch + i;
#ifdef INNER
        Kept kept = kept_none();
        Chunk* inner = inner_of(a) + lane * s.pitch + i;
#endif
        // The next entries are on their way while these are worked out.
        Words coming = stream(row);
        for (u32 k = 1; k <= AHEAD; k++)
            if (begin + k * stride < count) prefetch(row + k * s.pitch * LANES);
        copy_runs(a, i, runs);
        asm volatile("// pair loop, entries: " TEXT(CHUNK));
        if (FROM != PRUNE) asm volatile("// pair loop");
        for (u32 first = begin; first < count; first += stride) {
            const Words words = coming;
#ifdef FIXED
            const u32 place = 0, end = count - first;
#else
            // One register less.
            const u32 place = first, end = count;
#endif
            row += s.pitch * LANES;
            if (place + stride < end) coming = stream(row);
            if (AHEAD > 0 && place + (AHEAD + 1) * stride < end) prefetch(row + AHEAD * s.pitch * LANES);
#pragma unroll
            for (u32 batch = 0; batch < CHUNK; batch += BATCH) {
                // Beyond the end of a row stand entries that are no neighbors, but places of particles: worked out for nothing
                // they cost less than a branch.
                Slot q[BATCH];
                u32 code[BATCH];
#pragma unroll
                for (u32 m = 0; m < BATCH; m++) {
                    const Entry entry = entry_of(words, batch + m, runs);
#ifdef IMAGES
                    code[m] = (u32)(entry >> INDEX_BITS);
#else
                    code[m] = 0;
#endif
                    q[m] = gather(slots, place_of(entry), policy);
                }
#pragma unroll
                for (u32 m = 0; m < BATCH; m++) {
                    const bool near = add_pair<ADDS>(a, s, own, q[m], code[m], place + batch + m < end, unit_squared, work_unit, mine, f, sums);
#ifdef INNER
                    if (FROM == PRUNE) keep(kept, stored_of(words, batch + m), near);
#endif
                }
            }
#ifdef INNER
            if (FROM == PRUNE) write_kept(kept, inner, s.pitch * LANES);
#endif
        }
        if (FROM != PRUNE) asm volatile("// end of pair loop");
#ifdef INNER
        if (FROM == PRUNE) {
            kept_by(a, s, lane)[i] = kept.count;
            end_kept(kept, ((const Stored*)(a.list + lane * s.pitch + i))[0], inner, s.pitch * LANES);
        }
#endif
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
            if (!MOVES || broken)
                for (u32 axis = 0; axis < 3; axis++) axis_of(a.f, s, axis)[i] = (real)force[axis];
            if (broken) marks |= MARK_FORCE;
#ifdef THERMOSTATS
            else if (THEN == KICK) move_particle<true, false>(a, s, r, pace, i, force, nullptr, totals);
#endif
            else if (MOVES) marks |= move_particle<true, true, THEN == RECORD, FROM == PRUNE>(a, s, r, pace, i, force, next, totals + TOTALS);
        }
        if (ADDS != NOTHING) {
            for (u32 k = 0; k < (ADDS == ALL ? TOTALS : PRESSURE_TOTALS); k++) totals[k] += (double)sums[k];
        }
    }
    return marks;
}
