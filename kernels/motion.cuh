// Positions, velocities, and what pair arithmetic reads of them.

struct Point {
    double x[3];
};

// The largest number that positions and squares of displacements may be.
#define FURTHEST (sizeof(store) == 4 ? (store)3.4e38 : (store)1.79e308)

// Where a particle is, in double precision: `x` holds displacements since the last build where velocities are single.
__device__ __forceinline__ Point position_of(const Arrays& a, const Scene& s, const Run& r, u32 k) {
    Point p;
    for (u32 axis = 0; axis < 3; axis++) {
#ifdef DISPLACEMENTS
        p.x[axis] = axis_of(side_of(a.held_x, s, r.parity, 3), s, axis)[k] + (double)axis_of(a.x, s, axis)[k];
#else
        p.x[axis] = axis_of(a.x, s, axis)[k];
#endif
    }
    return p;
}

__device__ __forceinline__ u32 kind_of(const Arrays& a, const Scene& s, const Run& r, u32 k) {
#if TYPES > 1
    return side_of(a.held_kind, s, r.parity, 1)[k];
#else
    return 0;
#endif
}

// Fixed-point coordinates, modulo 2^32.
__device__ __forceinline__ int4 fixed_of(const Scene& s, const Point& p, u32 kind) {
    int q[3];
    for (u32 axis = 0; axis < 3; axis++) q[axis] = (int)__double2ll_rn((p.x[axis] - s.origin[axis]) * s.quanta[axis]);
    return make_int4(q[0], q[1], q[2], (int)kind);
}

// Fixed-point units of displacements.
struct Quanta {
    float of[3];
};

__device__ __forceinline__ Quanta quanta_of(const Scene& s) {
    Quanta q;
    for (u32 axis = 0; axis < 3; axis++) q.of[axis] = pinned((float)s.quanta[axis]);
    return q;
}

// What pair arithmetic reads at a step: two steps take turns, so that one is read while the next is written.
__device__ __forceinline__ Slot* slots_of(const Arrays& a, const Scene& s, i64 step) { return side_of(a.slots, s, (u32)step & 1, 1); }

__device__ __forceinline__ void pack(const Arrays& a, const Scene& s, const Run& r, const Quanta& quanta, u32 k, const store x[3], u32 kind, Slot* slots) {
#ifdef FIXED
#ifdef DISPLACEMENTS
    const int4 then = a.fixed[k];
    slots[k] = make_int4(then.x + __float2int_rn(x[0] * quanta.of[0]), then.y + __float2int_rn(x[1] * quanta.of[1]),
                           then.z + __float2int_rn(x[2] * quanta.of[2]), then.w);
#else
    const Point p = {{x[0], x[1], x[2]}};
    slots[k] = fixed_of(s, p, kind);
#endif
#else
    Point p;
    for (u32 axis = 0; axis < 3; axis++) {
#ifdef DISPLACEMENTS
        p.x[axis] = axis_of(side_of(a.held_x, s, r.parity, 3), s, axis)[k] + (double)x[axis];
#else
        p.x[axis] = x[axis];
#endif
    }
    Slot slot = {p.x[0], p.x[1], p.x[2], (double)kind};
    slots[k] = slot;
#endif
}

__device__ __forceinline__ void pack_particles(const Arrays& a, const Scene& s, const Run& r) {
    const Quanta quanta = quanta_of(s);
    Slot* slots = slots_of(a, s, r.step);
    for (u32 k = THREAD; k < r.n; k += THREADS) {
        store x[3];
        for (u32 axis = 0; axis < 3; axis++) x[axis] = axis_of(a.x, s, axis)[k];
        pack(a, s, r, quanta, k, x, kind_of(a, s, r, k), slots);
    }
}

// Numbers of a scene that motion needs for every particle, converted once.
struct Pace {
    store dt, half_kick, trigger, range;
    float prune; // squared displacement since the inner list was made that calls for a new one
    Quanta quanta;
};

__device__ __forceinline__ Pace pace_of(const Scene& s) {
    Pace p = {pinned((store)s.dt), pinned((store)s.half_kick), pinned((store)s.trigger), pinned((store)s.range), pinned((float)s.prune), quanta_of(s)};
    return p;
}

// How far a particle is from where the last build found it.
__device__ __forceinline__ void displacement_of(const Arrays& a, const Scene& s, const Run& r, u32 k, const store x[3], store d[3]) {
    for (u32 axis = 0; axis < 3; axis++) {
#ifdef DISPLACEMENTS
        d[axis] = x[axis];
#else
        d[axis] = x[axis] - __ldcs(axis_of(side_of(a.held_x, s, r.parity, 3), s, axis) + k);
#endif
    }
}

#if defined(NOISE) || defined(THERMOSTATS)
// The part of the run that lies behind at a step.
__device__ __forceinline__ double progress_of(const Scene& s, i64 step) { return step == s.run_first ? 0.0 : (double)(step - s.run_first) / (double)s.run_steps; }
#endif

#ifdef FORCES
// What fixes add to the force on a particle that pairs have given.
__device__ __forceinline__ void add_forces(const Arrays& a, const Scene& s, const Run& r, u32 k, real f[3]) {
    const real mass = (real)a.masses[kind_of(a, s, r, k)];
#ifdef GROUPS
    const u32 mask = side_of(a.held_mask, s, r.parity, 1)[k];
#else
    const u32 mask = 0;
#endif
#ifdef NOISE
    real v[3];
    for (u32 axis = 0; axis < 3; axis++) v[axis] = (real)axis_of(a.v, s, axis)[k];
    fixes_force(f, mass, mask, v, (real)s.dt, (real)progress_of(s, r.step), side_of(a.held_id, s, r.parity, 1)[k], r.step, s);
#else
    fixes_force(f, mass, mask, s);
#endif
}
#endif

// One particle under force f: with LAST the second half of a step, with INITIAL the first half of a step and what it has come
// to, as bits of MARK_. Reads and writes x, v; writes slots. With KINETIC_TOO its velocity between the two is added to kinetic
// sums; with PRUNED the inner list is of where it is before. Where there are thermostats, LAST adds its velocity to the sums of
// their groups instead, and what `scales` says comes before all but LAST. What it reads and writes is not read again in this step,
// and makes way in the caches.
template <bool LAST, bool INITIAL, bool KINETIC_TOO = false, bool PRUNED = false>
__device__ __forceinline__ u32 move_particle(const Arrays& a, const Scene& s, const Run& r, const Pace& pace, u32 k, const store f[3], Slot* slots, double* kinetic = nullptr, const Scales* scales = nullptr) {
    asm volatile("// move");
    store x[3], v[3];
    for (u32 axis = 0; axis < 3; axis++) {
        x[axis] = __ldcs(axis_of(a.x, s, axis) + k);
        v[axis] = __ldcs(axis_of(a.v, s, axis) + k);
    }
    const u32 kind = kind_of(a, s, r, k);
#ifdef MASSES
    const store half_kick = a.half_kicks[kind];
#else
    const store half_kick = pace.half_kick;
#endif
#ifdef GROUPS
    const u32 mask = side_of(a.held_mask, s, r.parity, 1)[k];
#else
    const u32 mask = 0;
#endif
    u32 far = 0;
    if (LAST) fixes_last(x, v, f, pace.dt, half_kick, mask, s);
#ifdef THERMOSTATS
    if (LAST) add_group_kinetic(a, kind, mask, v, kinetic);
    if (!LAST && scales) fixes_measured(v, mask, scales->end, s);
#endif
    if (KINETIC_TOO) add_kinetic(a, kind, v, kinetic);
    if (INITIAL) {
#ifdef INNER
        float then[3];
        if (PRUNED) {
            store d[3];
            displacement_of(a, s, r, k, x, d);
            for (u32 axis = 0; axis < 3; axis++) axis_of(a.pruned, s, axis)[k] = then[axis] = (float)d[axis];
        } else {
            for (u32 axis = 0; axis < 3; axis++) then[axis] = __ldcs(axis_of(a.pruned, s, axis) + k);
        }
#endif
#ifdef COORDINATES
        double origin[3];
        for (u32 axis = 0; axis < 3; axis++) origin[axis] = axis_of(side_of(a.held_x, s, r.parity, 3), s, axis)[k];
#else
        const double* origin = nullptr;
#endif
#ifdef THERMOSTATS
        fixes_initial(x, v, f, pace.dt, half_kick, mask, origin, scales->start, s);
#else
        fixes_initial(x, v, f, pace.dt, half_kick, mask, origin, s);
#endif
#if defined(CHECK) || defined(FIXED) || defined(INNER)
        store d[3];
        displacement_of(a, s, r, k, x, d);
        const store moved = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        const bool is_number = moved <= FURTHEST;
        // What is no number is too far as well: the build that follows finds it.
#ifdef CHECK
        far |= !(moved <= pace.trigger) ? MARK_FAR : 0;
#endif
#ifdef FIXED
        far |= !(moved <= pace.range) ? MARK_RANGE : 0;
#endif
#ifdef INNER
        float since[3];
        for (u32 axis = 0; axis < 3; axis++) since[axis] = (float)d[axis] - then[axis];
        far |= !(since[0] * since[0] + since[1] * since[1] + since[2] * since[2] <= pace.prune) ? MARK_PRUNE : 0;
#endif
#endif
#if !(defined(CHECK) || defined(FIXED) || defined(INNER))
        const bool is_number = fabs(x[0]) + fabs(x[1]) + fabs(x[2]) <= FURTHEST;
#endif
        far |= is_number ? 0 : MARK_POSITION;
        for (u32 axis = 0; axis < 3; axis++) __stcs(axis_of(a.x, s, axis) + k, x[axis]);
        pack(a, s, r, pace.quanta, k, x, kind, slots);
    }
    if (LAST || INITIAL || scales)
        for (u32 axis = 0; axis < 3; axis++) __stcs(axis_of(a.v, s, axis) + k, v[axis]);
    asm volatile("// end of move");
    return far;
}

#ifdef THERMOSTATS
// The second half of the last step, whose kinetic energies blocks leave. A particle's thread is the one that its force comes from,
// so that sums are those of a step in whose forces it has been done. Reads f.
__device__ __forceinline__ void kick_particles(const Arrays& a, const Scene& s, const Run& r) {
    const Pace pace = pace_of(s);
    double sums[THERMOSTATS] = {0};
    for (u32 i = threadIdx.x % LANES == 0 ? THREAD / LANES : r.n; i < r.n; i += THREADS / LANES) {
        store f[3];
        for (u32 axis = 0; axis < 3; axis++) f[axis] = (store)axis_of(a.f, s, axis)[i];
        move_particle<true, false>(a, s, r, pace, i, f, nullptr, sums);
    }
    leave_sums<THERMOSTATS>(sums, a.group_sums + blockIdx.x * THERMOSTATS);
}

// The first half of the step after `step`; with `end`, kinetic energies at the end of `step` have been left. Reads f. Returns what
// came to any of its particles.
template <bool PRUNED> __device__ __forceinline__ u32 begin_step(const Arrays& a, const Scene& s, const Run& r, i64 step, bool end) {
    __shared__ double kept[BATHS];
    const Scales scales = ask_thermostats<true>(a, s, step, end, progress_of(s, step + 1), kept);
    keep_baths(a, step + 1, kept);
    const Pace pace = pace_of(s);
    Slot* slots = slots_of(a, s, step + 1);
    u32 far = 0;
    for (u32 k = THREAD; k < r.n; k += THREADS) {
        store f[3];
        for (u32 axis = 0; axis < 3; axis++) f[axis] = (store)axis_of(a.f, s, axis)[k];
        far |= move_particle<false, true, false, PRUNED>(a, s, r, pace, k, f, slots, nullptr, &scales);
    }
    return far;
}
#else
// A thread a particle: with LAST the second half of the last step, with INITIAL the first half of this one. Reads f. Returns
// what came to any of its particles.
template <bool LAST, bool INITIAL> __device__ __forceinline__ u32 move_particles(const Arrays& a, const Scene& s, const Run& r) {
    const Pace pace = pace_of(s);
    Slot* slots = slots_of(a, s, r.step);
    u32 far = 0;
    for (u32 k = THREAD; k < r.n; k += THREADS) {
        store f[3];
        for (u32 axis = 0; axis < 3; axis++) f[axis] = (store)axis_of(a.f, s, axis)[k];
        far |= move_particle<LAST, INITIAL>(a, s, r, pace, k, f, slots);
    }
    return far;
}
#endif
