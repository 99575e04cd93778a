// What all stages share: places in the arrays, the barrier of the whole grid, reductions.

// Particles are dealt out to groups of threads in strides over the whole grid.
#define THREAD (blockIdx.x * (u32)blockDim.x + threadIdx.x)
#define THREADS (gridDim.x * (u32)blockDim.x)

// A column of an array that has one for each axis.
template <typename T> __device__ __forceinline__ T* axis_of(T* array, const Scene& s, u32 axis) {
    return array + axis * s.pitch;
}

// An array of which there is one before and one after a build.
template <typename T> __device__ __forceinline__ T* side_of(T* array, const Scene& s, u32 parity, u32 columns) {
    return array + parity * columns * s.pitch;
}

// Uniform over all threads of the grid; kept in registers, written back when a launch ends.
struct Run {
    u32 n;
    u32 parity;
    u32 half_done;
    u32 target; // of the barrier
    i64 step;
    u64 ago;
    u64 builds;
    u64 dangerous;
    i64 next_sort;
    u64 clock; // first thread only
};

// All threads of the grid wait here for each other; what was written before is seen after. The grid is resident as a whole
// (cooperative launch).
__device__ __forceinline__ void sync_grid(const Arrays& a, Run& r) {
    __syncthreads();
    if (threadIdx.x == 0) {
        volatile u32* barrier = &a.control->barrier;
        r.target += gridDim.x;
        __threadfence();
        atomicAdd((u32*)barrier, 1u);
        while ((int)(*barrier - r.target) < 0) {}
        __threadfence();
    }
    __syncthreads();
}

__device__ __forceinline__ u32 read_flag(const u32* flag) { return *(const volatile u32*)flag; }

// Books the time since the last call to a stage; the first thread's clock is everyone's, stages end at barriers.
__device__ __forceinline__ void book(const Arrays& a, Run& r, u32 stage) {
    if (THREAD == 0) {
        u64 now;
        asm volatile("mov.u64 %0, %%globaltimer;" : "=l"(now));
        a.control->nanoseconds[stage] += now - r.clock;
        r.clock = now;
    }
}

// Sum over the block, in an order that does not vary; every thread gets it. `scratch` holds one value a warp.
template <typename T> __device__ __forceinline__ T sum_block(T value, T* scratch) {
    for (u32 d = 16; d > 0; d >>= 1) value += __shfl_xor_sync(~0u, value, d);
    __syncthreads();
    if ((threadIdx.x & 31) == 0) scratch[threadIdx.x >> 5] = value;
    __syncthreads();
    T total = 0;
    for (u32 w = 0; w < blockDim.x >> 5; w++) total += scratch[w];
    return total;
}
