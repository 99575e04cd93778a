// The step loop: one launch runs as many steps as are left, and comes back only where the host or another kernel has to act.
// Compiled once more with RECORDS for scenes with outputs close to each other: some steps, evenly spaced, leave their sums as
// they pass, which no other step and no other scene pays for.

#ifdef RECORDS
#define STEPS advance_recording
#else
#define STEPS advance
#endif

// Forces of a step that has a next one: of the inner list, or of the list where the inner one is to be made.
template <Then THEN> __device__ __forceinline__ u32 pair_forces_from(const Arrays& a, const Scene& s, const Run& r, bool prune, double* sums = nullptr) {
#ifdef INNER
    return prune ? pair_forces<THEN, PRUNE>(a, s, r, sums) : pair_forces<THEN, NEAR>(a, s, r, sums);
#else
    return pair_forces<THEN>(a, s, r, sums);
#endif
}

// Leaves marks of a step for all blocks, and waits for theirs; returns those of all.
__device__ __forceinline__ u32 share_marks(const Arrays& a, Run& r, i64 step, u32 marks) {
    if (marks) atomicOr(&a.control->marks[step % MARKS], marks);
    return sync_grid(a, r, marks != 0) ? read_flag(&a.control->marks[step % MARKS]) : 0;
}

extern "C" __global__ void __launch_bounds__(BLOCK, BLOCKS_AT_LEAST) STEPS(const __grid_constant__ Arrays a, const __grid_constant__ Scene s, const __grid_constant__ Order o) {
    Control* c = a.control;
    u32 begin = c->begin, trouble = 0;
    u64 left = c->left;
    if (c->trouble || begin > BEGIN_PACK || (begin == BEGIN_MOVED && left == 0)) return;
    const u32 carried = c->carried;
#ifdef RECORDS
    const u32 first_record = c->recorded;
#endif
    Run r = begin_run(a);
    // The inner list is of no launch before this one, but where that has left off between two steps.
    bool prune = true;
    // Marks of the step that is looked at next.
    u32 marks = 0;
    if (begin == BEGIN_MOVED) {
        r.step++;
        marks = carried;
        prune = marks & MARK_PRUNE;
        begin = BEGIN_MOVE;
    } else if (begin == BEGIN_MOVE) {
        if (left != 0) {
            if (THREAD == 0) c->marks[(r.step + 2) % MARKS] = 0;
            r.step++;
#ifdef THERMOSTATS
            if (r.half_done) {
                kick_particles(a, s, r);
                sync_grid(a, r);
            }
            marks = begin_step<false>(a, s, r, r.step - 1, r.half_done);
#else
            marks = r.half_done ? move_particles<true, true>(a, s, r) : move_particles<false, true>(a, s, r);
#endif
            marks = share_marks(a, r, r.step, marks);
            book(a, r, STAGE_MODIFY);
        } else {
            begin = BEGIN_END;
        }
    } else if (begin == BEGIN_PACK) {
        pack_particles(a, s, r);
        sync_grid(a, r);
    }
#ifdef RECORDS
    // The next step to record, which follows from the number of this one alone, and how many have been since the host looked. A
    // record counts where its step is behind; the last step of all is left to `conclude`.
    i64 next = o.record_first;
    if (next < r.step) next += (r.step - next + o.record_stride - 1) / o.record_stride * o.record_stride;
    u32 recorded = first_record;
#endif
    while (begin != BEGIN_END) {
        if (begin == BEGIN_MOVE) {
            // Particles have moved to this step.
            left--;
            r.ago++;
            r.half_done = 1;
            begin = BEGIN_FORCE;
#ifdef REBUILDS
            if (r.ago >= s.delay && r.ago % s.every == 0) {
#ifdef CHECK
                const bool build = marks & MARK_FAR;
                if (build && r.ago == (s.every > s.delay ? s.every : s.delay)) r.dangerous++;
#else
                const bool build = true;
#endif
                if (build) {
                    r.builds++;
                    begin = BEGIN_BUILD;
                    break;
                }
            }
#endif
            if (marks & MARK_POSITION) {
                trouble = TROUBLE_POSITION;
                break;
            }
            if (marks & MARK_RANGE) {
                trouble = TROUBLE_RANGE;
                break;
            }
        }
        if (o.sums && left == 0) {
            begin = BEGIN_SUMS;
            break;
        }
        begin = BEGIN_MOVE;
        // Where steps are left, this one has begun: a set-up, which has none, is the only place where forces come first.
        if (left == 0 && !o.goes_on) {
            marks = share_marks(a, r, r.step + 1, pair_forces<STAY>(a, s, r));
            begin = BEGIN_END;
        } else {
            if (THREAD == 0) c->marks[(r.step + 2) % MARKS] = 0;
#if defined(RECORDS) && !defined(THERMOSTATS)
            if (r.step == next) {
                double sums[SUMS] = {0};
                marks = pair_forces_from<RECORD>(a, s, r, prune, sums);
                leave_sums(sums, a.record_sums + ((u64)recorded * gridDim.x + blockIdx.x) * SUMS);
                marks = share_marks(a, r, r.step + 1, marks);
            } else
#endif
#ifdef THERMOSTATS
            {
                // Kinetic energies are of all particles: none begins the next step before they are known.
                double groups[THERMOSTATS] = {0};
                marks = pair_forces_from<KICK>(a, s, r, prune, groups);
                leave_sums<THERMOSTATS>(groups, a.group_sums + blockIdx.x * THERMOSTATS);
                marks = share_marks(a, r, r.step + 1, marks);
                if (!(marks & MARK_FORCE)) {
                    marks = prune ? begin_step<true>(a, s, r, r.step, true) : begin_step<false>(a, s, r, r.step, true);
                    marks = share_marks(a, r, r.step + 1, marks);
                }
            }
#else
            marks = share_marks(a, r, r.step + 1, pair_forces_from<MOVE>(a, s, r, prune));
#endif
            prune = marks & MARK_PRUNE;
        }
        book(a, r, STAGE_PAIR);
        if (marks & MARK_FORCE) {
            trouble = TROUBLE_FORCE;
            break;
        }
#ifdef RECORDS
        if (left != 0 && r.step == next) recorded++, next += o.record_stride;
#endif
        if (left != 0) {
            r.step++;
        } else if (o.goes_on) {
            if (THREAD == 0) c->carried = marks;
            begin = BEGIN_MOVED;
            break;
        }
    }
#ifdef RECORDS
    if (THREAD == 0) c->recorded = recorded, c->record_blocks = gridDim.x;
#endif
    end_run(a, r, left, begin, trouble);
}
