// Sums of counts by the whole grid.

// Counts into first places: `counts` are set to zero on the way, `starts` gets one entry more. All blocks take part.
__device__ void scan_counts(const Arrays& a, Run& r, u32* counts, u32* starts, u32 buckets) {
    __shared__ u32 scratch[32];
    const u32 share = ((buckets + gridDim.x - 1) / gridDim.x + blockDim.x - 1) / blockDim.x * blockDim.x;
    const u64 begin = (u64)blockIdx.x * share;
    const u64 end = begin + share < buckets ? begin + share : buckets;
    u32 sum = 0;
    for (u64 b = begin + threadIdx.x; b < end; b += blockDim.x) sum += counts[b];
    sum = sum_block(sum, scratch);
    if (threadIdx.x == 0) a.block_counts[blockIdx.x] = sum;
    sync_grid(a, r);
    u32 before = 0;
    for (u32 b = threadIdx.x; b < blockIdx.x; b += blockDim.x) before += a.block_counts[b];
    before = sum_block(before, scratch);
    for (u64 first = begin; first < end; first += blockDim.x) {
        const u64 b = first + threadIdx.x;
        const u32 count = b < end ? counts[b] : 0;
        u32 upto = count;
        for (u32 d = 1; d < 32; d <<= 1) {
            const u32 below = __shfl_up_sync(~0u, upto, d);
            if ((threadIdx.x & 31) >= d) upto += below;
        }
        __syncthreads();
        if ((threadIdx.x & 31) == 31) scratch[threadIdx.x >> 5] = upto;
        __syncthreads();
        u32 warps = 0, all = 0;
        for (u32 w = 0; w < blockDim.x >> 5; w++) {
            if (w < threadIdx.x >> 5) warps += scratch[w];
            all += scratch[w];
        }
        if (b < end) {
            starts[b] = before + warps + upto - count;
            counts[b] = 0;
        }
        before += all;
    }
    if (THREAD == 0) starts[buckets] = r.n;
    sync_grid(a, r);
}
