// A build: sort and list, or the list alone where there was no room for it. A kernel of its own, for which `advance` comes
// back: it wants other registers, and the two are compiled side by side.

extern "C" __global__ void __launch_bounds__(BLOCK, 2) rebuild(const __grid_constant__ Arrays a, const __grid_constant__ Scene s, const __grid_constant__ Order o) {
    Control* c = a.control;
    u32 begin = c->begin, trouble = 0;
    if (c->trouble || (begin != BEGIN_BUILD && begin != BEGIN_LIST)) return;
    const u64 left = c->left;
    Run r = begin_run(a);
    if (begin == BEGIN_BUILD) {
        trouble = sort_particles(a, s, r, o.set_up);
        book(a, r, STAGE_SORT);
        if (!trouble) begin = BEGIN_LIST;
    }
    if (!trouble) {
        build_list(a, s, r);
        sync_grid(a, r);
        book(a, r, STAGE_LIST);
        r.ago = 0;
        if (read_flag(&a.control->wanted) > s.capacity) trouble = TROUBLE_CAPACITY;
        else begin = BEGIN_FORCE;
    }
    end_run(a, r, left, begin, trouble);
}
