// Particles dealt out to buckets by the digits of the buckets' numbers, the last digit first (the radix sort that Morillo et al. 2015
// take from a library, after Satish, Harris and Garland 2009, doi:10.1109/IPDPS.2009.5161005).

#ifdef RADIX
// Values of a digit; each thread of a block has one to look after.
#define DIGITS (1u << DIGIT_BITS)
static_assert(DIGITS == BLOCK, "a digit for each thread");

__device__ __forceinline__ u32 digit_of(u32 bucket, u32 bit) { return bucket >> bit & (DIGITS - 1); }

// Sorts by the digit that begins at a bit, from one side of the arrays to the other; what has the same digit stays in its order.
// A block has a piece of the particles.
__device__ void sort_by_digit(const Arrays& a, const Scene& s, Run& r, u32 bit, u32 from) {
    __shared__ u32 next[DIGITS];
    __shared__ u32 of_warp[BLOCK / 32][DIGITS];
    const u32 to = from ^ 1, lane = threadIdx.x & 31, warp = threadIdx.x >> 5;
    const u32 share = ((r.n + gridDim.x - 1) / gridDim.x + BLOCK - 1) / BLOCK * BLOCK;
    const u64 begin = (u64)blockIdx.x * share;
    const u64 end = begin + share < r.n ? begin + share : r.n;
    const u32* buckets = side_of(a.digit_bucket, s, from, 1);
    const u32* particles = side_of(a.digit_particle, s, from, 1);
    next[threadIdx.x] = 0;
    __syncthreads();
    for (u64 k = begin + threadIdx.x; k < end; k += BLOCK) atomicAdd(&next[digit_of(buckets[k], bit)], 1u);
    __syncthreads();
    // All pieces' counts of a digit before those of the next one.
    a.digit_counts[threadIdx.x * gridDim.x + blockIdx.x] = next[threadIdx.x];
    sync_grid(a, r);
    scan_counts(a, r, a.digit_counts, a.digit_starts, DIGITS * gridDim.x);
    next[threadIdx.x] = a.digit_starts[threadIdx.x * gridDim.x + blockIdx.x];
    for (u32 w = 0; w < BLOCK / 32; w++) of_warp[w][threadIdx.x] = 0;
    __syncthreads();
    for (u64 first = begin; first < end; first += BLOCK) {
        const u64 k = first + threadIdx.x;
        const bool there = k < end;
        const u32 bucket = there ? buckets[k] : 0, particle = there ? particles[k] : 0;
        // A digit that none has where there is no particle.
        const u32 digit = there ? digit_of(bucket, bit) : DIGITS;
        const u32 same = __match_any_sync(~0u, digit), before = __popc(same & ((1u << lane) - 1));
        if (there && before == 0) of_warp[warp][digit] = __popc(same);
        __syncthreads();
        if (there) {
            u32 at = next[digit] + before;
            for (u32 w = 0; w < warp; w++) at += of_warp[w][digit];
            side_of(a.digit_bucket, s, to, 1)[at] = bucket;
            side_of(a.digit_particle, s, to, 1)[at] = particle;
        }
        __syncthreads();
        for (u32 w = 0; w < BLOCK / 32; w++) {
            next[threadIdx.x] += of_warp[w][threadIdx.x];
            of_warp[w][threadIdx.x] = 0;
        }
        __syncthreads();
    }
    sync_grid(a, r);
}

// From the bucket of each particle to first places of buckets and what lies there.
__device__ void deal_by_digits(const Arrays& a, const Scene& s, Run& r, u32 buckets) {
    for (u32 k = THREAD; k < r.n; k += THREADS) {
        side_of(a.digit_bucket, s, 0, 1)[k] = a.bucket[k];
        side_of(a.digit_particle, s, 0, 1)[k] = k;
    }
    sync_grid(a, r);
    u32 side = 0;
    const u32 bits = 32 - __clz(buckets - 1);
    for (u32 bit = 0; bit < bits; bit += DIGIT_BITS, side ^= 1) sort_by_digit(a, s, r, bit, side);
    const u32* sorted = side_of(a.digit_bucket, s, side, 1);
    for (u32 p = THREAD; p < r.n; p += THREADS) {
        const u32 k = side_of(a.digit_particle, s, side, 1)[p];
        a.dealt[p] = k;
        a.dealt_tie[p] = a.tie[k];
        // Buckets after that of the last particle begin here, empty ones too.
        for (u32 b = p == 0 ? 0 : sorted[p - 1] + 1; b <= sorted[p]; b++) a.starts[b] = p;
    }
    for (u32 b = (r.n == 0 ? 0 : sorted[r.n - 1] + 1) + THREAD; b <= buckets; b += THREADS) a.starts[b] = r.n;
    sync_grid(a, r);
}
#endif
