// A build: sort and list, or the list alone where there was no room for it.

// Returns what stops it, if anything; `begin` is where to go on.
__device__ __forceinline__ u32 build(const Arrays& a, const Scene& s, Run& r, const Order& o, u32& begin) {
    if (begin == BEGIN_BUILD) {
        const u32 trouble = sort_particles(a, s, r, o.set_up);
        book(a, r, STAGE_SORT);
        if (trouble) return trouble;
        begin = BEGIN_LIST;
    }
    build_list(a, s, r);
    sync_grid(a, r);
    book(a, r, STAGE_LIST);
    r.ago = 0;
    if (read_flag(&a.control->wanted) > s.capacity) return TROUBLE_CAPACITY;
    begin = BEGIN_FORCE;
    return 0;
}

#ifdef APART
// By itself, with registers of its own: `advance` comes back for it.
extern "C" __global__ void __launch_bounds__(BLOCK, 2) rebuild(const __grid_constant__ Arrays a, const __grid_constant__ Scene s, const __grid_constant__ Order o) {
    Control* c = a.control;
    u32 begin = c->begin;
    if (c->trouble || (begin != BEGIN_BUILD && begin != BEGIN_LIST)) return;
    const u64 left = c->left;
    Run r = begin_run(a);
    const u32 trouble = build(a, s, r, o, begin);
    end_run(a, r, left, begin, trouble);
}
#endif
