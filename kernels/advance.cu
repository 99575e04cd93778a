// The step loop: one launch runs as many steps as are asked for, list builds among them, and comes back only to put out
// something or because the host has to act.

extern "C" __global__ void __launch_bounds__(BLOCK, BLOCKS_AT_LEAST) advance(const __grid_constant__ Arrays a, const __grid_constant__ Scene s, const __grid_constant__ Order o) {
    Control* c = a.control;
    Run r = {c->n, c->parity, c->half_done, 0, c->step, c->ago, c->builds, c->dangerous, c->next_sort, 0};
    u64 left = o.steps;
    u32 begin = o.begin, trouble = 0;
    sync_grid(a, r);
    book(a, r, STAGE_OTHER);
    for (;;) {
        bool build = begin == BEGIN_BUILD;
        if (begin == BEGIN_MOVE) {
            if (left == 0) break;
            left--;
            r.step++;
            r.ago++;
            if (THREAD == 0) c->moved[(r.step + 1) % 3] = 0;
            move_particles<true>(a, s, r);
            r.half_done = 1;
            sync_grid(a, r);
            book(a, r, STAGE_MODIFY);
            const u32 moved = read_flag(&c->moved[r.step % 3]);
#ifdef REBUILDS
            if (r.ago >= s.delay && r.ago % s.every == 0) {
#ifdef CHECK
                build = moved & 1;
                if (build && r.ago == (s.every > s.delay ? s.every : s.delay)) r.dangerous++;
#else
                build = true;
#endif
            }
            r.builds += build;
#endif
            if (!build && moved & 2) {
                trouble = TROUBLE_RANGE;
                begin = BEGIN_FORCE;
                break;
            }
        }
        if (build) {
            trouble = sort_particles(a, s, r, o.set_up);
            book(a, r, STAGE_SORT);
            if (trouble) {
                begin = BEGIN_BUILD;
                break;
            }
        }
        if (build || begin == BEGIN_LIST) {
            build_list(a, s, r);
            sync_grid(a, r);
            book(a, r, STAGE_LIST);
            r.ago = 0;
            if (read_flag(&c->wanted) > s.capacity) {
                trouble = TROUBLE_CAPACITY;
                begin = BEGIN_LIST;
                break;
            }
        }
        if (begin == BEGIN_PACK) {
            pack_particles(a, s, r);
            sync_grid(a, r);
        }
        if (o.sums && left == 0) pair_forces<true>(a, s, r);
        else pair_forces<false>(a, s, r);
        sync_grid(a, r);
        book(a, r, STAGE_PAIR);
        begin = BEGIN_MOVE;
        trouble = read_flag(&c->force_trouble);
        if (trouble) break;
    }
    if (!trouble && o.finish) {
        move_particles<false>(a, s, r);
        r.half_done = 0;
        book(a, r, STAGE_MODIFY);
    }
    if (THREAD == 0) {
        c->parity = r.parity;
        c->half_done = r.half_done;
        c->step = r.step;
        c->ago = r.ago;
        c->builds = r.builds;
        c->dangerous = r.dangerous;
        c->next_sort = r.next_sort;
        c->left = left;
        c->begin = begin;
        c->trouble = trouble;
    }
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
        if (threadIdx.x == 0) a.block_sums[blockIdx.x * 7 + k] = total;
    }
}
