// Particles into the order of cells: wrapped, counted by octant, dealt out, ranked inside each octant, gathered.

// Brings a position into the box by one image at most; returns whether it is inside then.
__device__ __forceinline__ bool wrap(const Scene& s, Point& p, int image[3]) {
    bool inside = true;
    for (u32 axis = 0; axis < 3; axis++) {
        if (PERIODIC >> axis & 1) {
            double wrapped, images;
            wrap_once(p.x[axis], s.lo[axis], s.hi[axis], &wrapped, &images);
            p.x[axis] = wrapped;
            image[axis] += (int)images;
        }
        inside &= p.x[axis] >= s.lo[axis] && p.x[axis] < s.hi[axis];
    }
    return inside;
}

#ifdef SHRINKS
// Smallest coordinate along each axis, then largest with the other sign; one set a block.
__device__ void find_bounds(const Arrays& a, const Scene& s, const Run& r) {
    __shared__ double scratch[32];
    for (u32 side = 0; side < 6; side++) {
        double least = 1e300;
        for (u32 k = THREAD; k < r.n; k += THREADS) {
            const double x = position_of(a, s, r, k).x[side % 3];
            least = fmin(least, side < 3 ? x : -x);
        }
        for (u32 d = 16; d > 0; d >>= 1) least = fmin(least, __shfl_xor_sync(~0u, least, d));
        if ((threadIdx.x & 31) == 0) scratch[threadIdx.x >> 5] = least;
        __syncthreads();
        if (threadIdx.x == 0) {
            for (u32 w = 0; w < blockDim.x >> 5; w++) least = fmin(least, scratch[w]);
            a.block_sums[blockIdx.x * TOTALS + side] = least;
        }
        __syncthreads();
    }
}
#endif

// Whether what stands in place q comes before what stands in place p of the same bucket.
__device__ __forceinline__ bool comes_before(const Arrays& a, u32 q, u32 p, u64 tie) {
#ifdef FOLDED
    const u64 other = a.cell[a.dealt[q]], own = a.cell[a.dealt[p]];
    if (other != own) return other < own;
#endif
    return a.dealt_tie[q] < tie;
}

// Deals the particles out to their buckets.
#ifdef RADIX
__device__ void deal(const Arrays& a, const Scene& s, Run& r, u32 buckets) { deal_by_digits(a, s, r, buckets); }

__device__ __forceinline__ void count(const Arrays&, u32) {}
#else
__device__ void deal(const Arrays& a, const Scene&, Run& r, u32 buckets) {
    scan_counts(a, r, a.counts, a.starts, buckets);
    for (u32 k = THREAD; k < r.n; k += THREADS) {
        const u32 to = a.starts[a.bucket[k]] + a.arrival[k];
        a.dealt[to] = k;
        a.dealt_tie[to] = a.tie[k];
    }
    sync_grid(a, r);
}

// Counts a particle into its bucket.
__device__ __forceinline__ void count(const Arrays& a, u32 k) { a.arrival[k] = atomicAdd(&a.counts[a.bucket[k]], 1u); }
#endif

// From buckets and ties to the order of all particles: order[place] is the particle's place now.
__device__ void order_particles(const Arrays& a, const Scene& s, Run& r, u32 buckets) {
    deal(a, s, r, buckets);
    for (u32 p = THREAD; p < r.n; p += THREADS) {
        const u32 k = a.dealt[p], bucket = a.bucket[k];
        const u32 first = a.starts[bucket], end = a.starts[bucket + 1];
        const u64 tie = a.dealt_tie[p];
        u32 rank = 0;
        for (u32 q = first; q < end; q++) rank += comes_before(a, q, p, tie);
        a.order[first + rank] = k;
    }
    sync_grid(a, r);
}

// Where particle k, wrapped to p, is sorted to; returns whether the grid reaches there.
__device__ __forceinline__ bool write_key(const Arrays& a, const Scene& s, const Run& r, u32 k, const Point& p) {
    u32 cell[3], octant, part;
    const bool inside = key_of(s, p, cell, &octant, &part);
    a.bucket[k] = table_of(s, cell[0], cell[1], cell[2]) * OCTANTS + octant;
#ifdef FOLDED
    a.cell[k] = cell_number(cell);
#endif
    a.tie[k] = (u64)part << 32 | side_of(a.held_id, s, r.parity, 1)[k];
    return inside;
}

#ifdef STORAGE_SORT
// Storage order by LAMMPS's bins; inside a bin it stays. Writes new_home.
__device__ void sort_storage(const Arrays& a, const Scene& s, Run& r) {
    for (u32 k = THREAD; k < r.n; k += THREADS) {
        Point p = position_of(a, s, r, k);
        int image[3] = {0, 0, 0};
        wrap(s, p, image);
        u32 bin[3];
        for (u32 axis = 0; axis < 3; axis++) {
            double place, number, eighth;
            locate(p.x[axis], s.lo[axis], s.storage_inverse[axis], (double)(s.storage_bins[axis] - 1), &place, &number, &eighth);
            bin[axis] = (u32)number;
        }
        const u32 bucket = number_of(bin[0], bin[1], bin[2], s.storage_bins);
        a.bucket[k] = bucket;
#ifdef FOLDED
        a.cell[k] = 0;
#endif
        a.tie[k] = side_of(a.held_home, s, r.parity, 1)[k];
        count(a, k);
    }
    sync_grid(a, r);
    order_particles(a, s, r, s.storage_bins[0] * s.storage_bins[1] * s.storage_bins[2]);
    for (u32 home = THREAD; home < r.n; home += THREADS) a.new_home[a.order[home]] = home;
    sync_grid(a, r);
}
#endif

// Wraps and sorts the particles: from x, v and one side of what is held to its other side. Returns what stops it, if anything.
__device__ u32 sort_particles(const Arrays& a, const Scene& s, Run& r, bool set_up) {
#ifdef STORAGE_SORT
    const bool sorted = set_up || r.step >= r.next_sort;
#else
    const bool sorted = false;
#endif
#ifdef LOSES
    fill_holes(a, s, r);
#endif
    u32 trouble = 0;
    for (u32 k = THREAD; k < r.n; k += THREADS) {
        Point p = position_of(a, s, r, k);
        int image[3] = {0, 0, 0};
        bool finite = true;
        for (u32 axis = 0; axis < 3; axis++)
            finite &= isfinite(p.x[axis]) && isfinite(axis_of(a.v, s, axis)[k]);
        if (!finite) trouble |= TROUBLE_POSITION;
        else if (!wrap(s, p, image)) {
            trouble |= TROUBLE_LOST;
#ifdef LOSES
            tell_lost(a, s, r, k, p);
#endif
        }
        if (!trouble && !write_key(a, s, r, k, p)) trouble |= TROUBLE_GRID;
        // Where there is trouble the host starts anew.
        if (!trouble && !sorted) count(a, k);
    }
    if (trouble) atomicOr(&a.control->sort_trouble, trouble);
    sync_grid(a, r);
    trouble = read_flag(&a.control->sort_trouble);
    if (trouble) return trouble;
#ifdef STORAGE_SORT
    if (sorted) {
        sort_storage(a, s, r);
        r.next_sort = (r.step / s.storage_every + 1) * s.storage_every;
        // It has used these arrays.
        for (u32 k = THREAD; k < r.n; k += THREADS) {
            Point p = position_of(a, s, r, k);
            int image[3] = {0, 0, 0};
            wrap(s, p, image);
            write_key(a, s, r, k, p);
            count(a, k);
        }
        sync_grid(a, r);
    }
#endif
    order_particles(a, s, r, s.buckets);
    const u32 to = r.parity ^ 1;
    for (u32 t = THREAD; t < r.n; t += THREADS) {
        const u32 k = a.order[t];
        Point p = position_of(a, s, r, k);
        int image[3];
        for (u32 axis = 0; axis < 3; axis++) image[axis] = axis_of(side_of(a.held_image, s, r.parity, 3), s, axis)[k];
        wrap(s, p, image);
        for (u32 axis = 0; axis < 3; axis++) {
            axis_of(side_of(a.held_x, s, to, 3), s, axis)[t] = p.x[axis];
            axis_of(side_of(a.held_v, s, to, 3), s, axis)[t] = axis_of(a.v, s, axis)[k];
            axis_of(side_of(a.held_image, s, to, 3), s, axis)[t] = image[axis];
        }
        side_of(a.held_id, s, to, 1)[t] = side_of(a.held_id, s, r.parity, 1)[k];
        side_of(a.held_source, s, to, 1)[t] = side_of(a.held_source, s, r.parity, 1)[k];
#ifdef HOMES
        u32 home = side_of(a.held_home, s, r.parity, 1)[k];
#ifdef STORAGE_SORT
        if (sorted) home = a.new_home[k];
#endif
        side_of(a.held_home, s, to, 1)[t] = home;
#endif
#if TYPES > 1
        side_of(a.held_kind, s, to, 1)[t] = side_of(a.held_kind, s, r.parity, 1)[k];
#endif
#ifdef GROUPS
        side_of(a.held_mask, s, to, 1)[t] = side_of(a.held_mask, s, r.parity, 1)[k];
#endif
        a.fixed[t] = fixed_of(s, p, kind_of(a, s, r, k));
    }
    if (THREAD == 0) a.control->entries = a.control->tests = a.control->taken = 0;
    sync_grid(a, r);
    r.parity = to;
    return 0;
}
