// The step loop: one launch runs as many steps as are left, and comes back only where the host or another kernel has to act.

extern "C" __global__ void __launch_bounds__(BLOCK, BLOCKS_AT_LEAST) advance(const __grid_constant__ Arrays a, const __grid_constant__ Scene s, const __grid_constant__ Order o) {
    Control* c = a.control;
    u32 begin = c->begin, trouble = 0;
    if (c->trouble || begin > BEGIN_PACK) return;
    u64 left = c->left;
    Run r = begin_run(a);
    for (;;) {
        if (begin == BEGIN_MOVE) {
            if (left == 0) {
                begin = BEGIN_END;
                break;
            }
            left--;
            r.step++;
            r.ago++;
            if (THREAD == 0) c->moved[(r.step + 1) % MARKS] = 0;
            move_particles<true>(a, s, r);
            r.half_done = 1;
            sync_grid(a, r);
            book(a, r, STAGE_MODIFY);
            const u32 moved = read_flag(&c->moved[r.step % MARKS]);
            begin = BEGIN_FORCE;
#ifdef REBUILDS
            if (r.ago >= s.delay && r.ago % s.every == 0) {
#ifdef CHECK
                const bool build = moved & 1;
                if (build && r.ago == (s.every > s.delay ? s.every : s.delay)) r.dangerous++;
#else
                const bool build = true;
#endif
                if (build) {
                    r.builds++;
                    begin = BEGIN_BUILD;
                }
            }
#endif
            if (begin == BEGIN_FORCE && moved & 2) {
                trouble = TROUBLE_RANGE;
                break;
            }
        }
        if (begin == BEGIN_BUILD) break;
        if (begin == BEGIN_PACK) {
            pack_particles(a, s, r);
            sync_grid(a, r);
        }
        if (o.sums && left == 0) {
            begin = BEGIN_SUMS;
            break;
        }
        pair_forces<false>(a, s, r);
        sync_grid(a, r);
        book(a, r, STAGE_PAIR);
        begin = BEGIN_MOVE;
        trouble = read_flag(&c->force_trouble);
        if (trouble) break;
    }
    end_run(a, r, left, begin, trouble);
}
