// After the sort, and again where there was no room for the list.

// Four blocks: registers, and shared memory, for 16 warps on a multiprocessor.
extern "C" __global__ void __launch_bounds__(LIST_BLOCK, 4) list(const __grid_constant__ Arrays a, const __grid_constant__ Scene s, const __grid_constant__ Order o) {
    const Control* c = a.control;
    if (c->trouble || c->begin != BEGIN_LIST) return;
    const u64 left = c->left;
    Run r = begin_run(a);
    build_list(a, s, r);
    sync_grid(a, r);
    book(a, r, STAGE_LIST);
    // Once more, not to keep it in registers during the build.
    read_run(a, r);
    r.ago = 0;
    const u32 trouble = read_flag(&c->sort_trouble) | (read_flag(&c->wanted) <= s.capacity ? 0 : TROUBLE_CAPACITY);
    end_run(a, r, left, trouble ? BEGIN_LIST : BEGIN_FORCE, trouble);
}
