// What only the last step before an output has: energy and virial, the second half of the step, kinetic sums.

// The second half of the step where LAST, and kinetic sums. A particle's is the thread that its force comes from, so that sums
// are those of a step that `advance_recording` has gone on from. Reads f.
template <bool LAST> __device__ __forceinline__ void finish_particles(const Arrays& a, const Scene& s, const Run& r, double sums[SUMS], const Scales* scales = nullptr) {
    const Pace pace = pace_of(s);
    if (threadIdx.x % LANES != 0) return;
    for (u32 i = THREAD / LANES; i < r.n; i += THREADS / LANES) {
        store f[3] = {0, 0, 0};
        if (LAST)
            for (u32 axis = 0; axis < 3; axis++) f[axis] = (store)axis_of(a.f, s, axis)[i];
        move_particle<LAST, false, true>(a, s, r, pace, i, f, nullptr, sums + TOTALS, scales);
    }
}

extern "C" __global__ void __launch_bounds__(BLOCK, BLOCKS_AT_LEAST) conclude(const __grid_constant__ Arrays a, const __grid_constant__ Scene s, const __grid_constant__ Order o) {
    Control* c = a.control;
    u32 begin = c->begin, trouble = 0;
    if (c->trouble || (begin != BEGIN_SUMS && begin != BEGIN_END)) return;
    Run r = begin_run(a);
    double sums[SUMS] = {0};
    if (begin == BEGIN_SUMS) {
        const bool broken = sync_grid(a, r, pair_forces<KEEP>(a, s, r, sums) != 0);
        book(a, r, STAGE_PAIR);
        trouble = broken ? TROUBLE_FORCE : 0;
        begin = broken ? BEGIN_MOVE : BEGIN_END;
    }
    if (!trouble) {
#ifdef THERMOSTATS
        __shared__ double kept[BATHS];
        const bool ends = o.finish && r.half_done;
        if (ends) {
            kick_particles(a, s, r);
            sync_grid(a, r);
            const Scales scales = ask_thermostats<false>(a, s, r.step, true, 0.0, kept);
            finish_particles<false>(a, s, r, sums, &scales);
        } else {
            finish_particles<false>(a, s, r, sums);
        }
#else
        if (o.finish && r.half_done) finish_particles<true>(a, s, r, sums);
        else finish_particles<false>(a, s, r, sums);
#endif
        if (o.finish) r.half_done = 0;
        leave_sums(sums, a.block_sums + blockIdx.x * SUMS);
        sync_grid(a, r);
#ifdef THERMOSTATS
        if (ends) keep_baths(a, r.step, kept);
#endif
        if (blockIdx.x == 0) add_blocks(a.block_sums, gridDim.x, c->sums);
        book(a, r, STAGE_MODIFY);
    }
    end_run(a, r, 0, begin, trouble);
}
