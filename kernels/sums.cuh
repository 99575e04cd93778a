// Sums over all particles that outputs want, always added up in the same order: a thread's in the order of its particles, the
// threads of a block, the blocks. Which kernel adds them up does not show, as long as it has as many blocks.

// Adds m v v of one particle: xx, yy, zz, xy, xz, yz.
__device__ __forceinline__ void add_kinetic(const Arrays& a, u32 kind, const store v[3], double sums[KINETIC]) {
    const double x = v[0], y = v[1], z = v[2], m = a.masses[kind];
    sums[0] += m * x * x, sums[1] += m * y * y, sums[2] += m * z * z;
    sums[3] += m * x * y, sums[4] += m * x * z, sums[5] += m * y * z;
}

// Sums of all threads of a block, one set of so many numbers; all of its threads call it.
template <u32 COUNT = SUMS> __device__ __forceinline__ void leave_sums(const double sums[COUNT], double* to) {
    __shared__ double scratch[COUNT][BLOCK / 32];
    // Another call may still read.
    __syncthreads();
    for (u32 k = 0; k < COUNT; k++) {
        double sum = sums[k];
        for (u32 d = 16; d > 0; d >>= 1) sum += __shfl_xor_sync(~0u, sum, d);
        if ((threadIdx.x & 31) == 0) scratch[k][threadIdx.x >> 5] = sum;
    }
    __syncthreads();
    if (threadIdx.x < COUNT) {
        double sum = 0;
        for (u32 w = 0; w < BLOCK / 32; w++) sum += scratch[threadIdx.x][w];
        to[threadIdx.x] = sum;
    }
}

// Adds up what so many blocks have left; one block of threads does it, each thread a part of the blocks for one of the numbers.
template <u32 COUNT = SUMS> __device__ __forceinline__ void add_blocks(const double* from, u32 blocks, double* to) {
    const u32 COLUMNS = 16, PARTS = BLOCK / COLUMNS;
    static_assert(COUNT <= COLUMNS, "a thread for each number");
    __shared__ double scratch[PARTS][COLUMNS];
    const u32 k = threadIdx.x % COLUMNS, part = threadIdx.x / COLUMNS;
    double sum = 0;
    if (k < COUNT) {
        for (u32 b = part; b < blocks; b += PARTS) sum += from[b * COUNT + k];
    }
    // Another call may still read.
    __syncthreads();
    scratch[part][k] = sum;
    __syncthreads();
    if (threadIdx.x < COUNT) {
        double all = 0;
        for (u32 p = 0; p < PARTS; p++) all += scratch[p][threadIdx.x];
        to[threadIdx.x] = all;
    }
}
