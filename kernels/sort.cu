// A build begins: `advance` comes back for it.

extern "C" __global__ void __launch_bounds__(BLOCK) sort(const __grid_constant__ Arrays a, const __grid_constant__ Scene s, const __grid_constant__ Order o) {
    Control* c = a.control;
    if (c->trouble || c->begin != BEGIN_BUILD) return;
    const u64 left = c->left;
#ifdef SHRINKS
    // Sides follow the particles before these are sorted: the host moves them.
    const u32 bounded = c->bounded;
    Run r = begin_run(a);
    if (!bounded) {
        find_bounds(a, s, r);
        end_run(a, r, left, BEGIN_BUILD, TROUBLE_BOUNDS);
        return;
    }
    if (THREAD == 0) c->bounded = 0;
#else
    Run r = begin_run(a);
#endif
    const u32 trouble = sort_particles(a, s, r, o.set_up);
    book(a, r, STAGE_SORT);
    end_run(a, r, left, trouble ? BEGIN_BUILD : BEGIN_LIST, trouble);
}
