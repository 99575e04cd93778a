// Thermostats: velocities of a group scaled by what its kinetic energy is. A step has two barriers then: all particles have had
// the second half of a step before any begins the next one.

struct Scales;

#ifdef THERMOSTATS
// Factors on velocities at the end of a step and at the start of the next.
struct Scales {
    double end[THERMOSTATS], start[THERMOSTATS];
};

// Adds m v^2 of one particle to the sums of its groups.
__device__ __forceinline__ void add_group_kinetic(const Arrays& a, u32 kind, u32 mask, const store v[3], double sums[THERMOSTATS]) {
    const double x = v[0], y = v[1], z = v[2];
    const double sum = a.masses[kind] * (x * x + y * y + z * z);
    for (u32 t = 0; t < THERMOSTATS; t++) sums[t] += THERMOSTAT_GROUPS[t] == 1u || mask & THERMOSTAT_GROUPS[t] ? sum : 0.0;
}

// What thermostats have kept as of a step: two steps take turns, so that one is read while the next is written.
__device__ __forceinline__ double* baths_of(const Arrays& a, i64 step) { return a.baths + (step & 1) * BATHS; }

// Asks the thermostats: with END at the end of step `step`, from the sums that all blocks have left; with START at the start of
// the step after it, whose `progress` is given. Every block works all of it out; `kept` is in shared memory, BATHS numbers.
template <bool START> __device__ __forceinline__ Scales ask_thermostats(const Arrays& a, const Scene& s, i64 step, bool end, double progress, double* kept) {
    __shared__ double kinetic[THERMOSTATS], scales[2 * THERMOSTATS];
    if (end) add_blocks<THERMOSTATS>(a.group_sums, gridDim.x, kinetic);
    __syncthreads();
    if (threadIdx.x == 0) {
        for (u32 k = 0; k < BATHS; k++) kept[k] = baths_of(a, step)[k];
        if (end) thermostats_end(kept, kinetic, s, scales);
        if (START) thermostats_start(kept, progress, s, scales + THERMOSTATS);
    }
    __syncthreads();
    Scales all;
    for (u32 t = 0; t < THERMOSTATS; t++) {
        all.end[t] = end ? scales[t] : 1.0;
        all.start[t] = START ? scales[THERMOSTATS + t] : 1.0;
    }
    // Another call may still read.
    __syncthreads();
    return all;
}

// Leaves what thermostats keep, as of a step that no block reads any more.
__device__ __forceinline__ void keep_baths(const Arrays& a, i64 step, const double* kept) {
    if (THREAD == 0)
        for (u32 k = 0; k < BATHS; k++) baths_of(a, step)[k] = kept[k];
}
#endif
