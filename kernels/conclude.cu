// What only the last step before an output has: energy and virial, the second half of the step, kinetic energy.

extern "C" __global__ void __launch_bounds__(BLOCK) conclude(const __grid_constant__ Arrays a, const __grid_constant__ Scene s, const __grid_constant__ Order o) {
    Control* c = a.control;
    u32 begin = c->begin, trouble = 0;
    if (c->trouble || (begin != BEGIN_SUMS && begin != BEGIN_END)) return;
    Run r = begin_run(a);
    if (begin == BEGIN_SUMS) {
        const bool broken = sync_grid(a, r, pair_forces<KEEP>(a, s, r) != 0);
        book(a, r, STAGE_PAIR);
        trouble = broken ? TROUBLE_FORCE : 0;
        begin = broken ? BEGIN_MOVE : BEGIN_END;
    }
    if (!trouble && o.finish) {
        if (r.half_done) move_particles<true, false>(a, s, r);
        r.half_done = 0;
        book(a, r, STAGE_MODIFY);
    }
    end_run(a, r, 0, begin, trouble);
}

// Sums of m v v over the particles, one set a block: xx, yy, zz, xy, xz, yz.
extern "C" __global__ void __launch_bounds__(BLOCK) kinetic(const __grid_constant__ Arrays a, const __grid_constant__ Scene s) {
    __shared__ double scratch[32];
    Run r = {a.control->n, a.control->parity};
    double totals[6] = {0, 0, 0, 0, 0, 0};
    for (u32 k = THREAD; k < r.n; k += THREADS) {
        const double x = axis_of(a.v, s, 0)[k], y = axis_of(a.v, s, 1)[k], z = axis_of(a.v, s, 2)[k];
#if TYPES > 1
        const double m = a.masses[kind_of(a, s, r, k)];
#else
        const double m = a.masses[0];
#endif
        totals[0] += m * x * x, totals[1] += m * y * y, totals[2] += m * z * z;
        totals[3] += m * x * y, totals[4] += m * x * z, totals[5] += m * y * z;
    }
    for (u32 k = 0; k < 6; k++) {
        const double total = sum_block(totals[k], scratch);
        if (threadIdx.x == 0) a.block_sums[blockIdx.x * TOTALS + k] = total;
    }
}
