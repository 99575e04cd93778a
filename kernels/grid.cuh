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

// The neighbor's place in an entry.
__device__ __forceinline__ u32 place_of(Entry entry) {
#ifdef IMAGES
    return (u32)(entry & (((Entry)1 << INDEX_BITS) - 1));
#else
    return entry;
#endif
}

// A number converted here, and not again wherever it is used.
__device__ __forceinline__ float pinned(float x) {
    asm volatile("" : "+f"(x));
    return x;
}
__device__ __forceinline__ double pinned(double x) { return x; }

// Uniform over all threads of the grid; kept in registers while a kernel runs.
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

// Where the last kernel left off. All threads of the grid have read it when this returns.
__device__ __forceinline__ Run begin_run(const Arrays& a) {
    const Control* c = a.control;
    Run r = {c->n, c->parity, c->half_done, c->target, c->step, c->ago, c->builds, c->dangerous, c->next_sort, 0};
    sync_grid(a, r);
    book(a, r, STAGE_OTHER);
    return r;
}

__device__ __forceinline__ void end_run(const Arrays& a, const Run& r, u64 left, u32 begin, u32 trouble) {
    if (THREAD != 0) return;
    Control* c = a.control;
    c->parity = r.parity;
    c->half_done = r.half_done;
    c->target = r.target;
    c->step = r.step;
    c->ago = r.ago;
    c->builds = r.builds;
    c->dangerous = r.dangerous;
    c->next_sort = r.next_sort;
    c->left = left;
    c->begin = begin;
    c->trouble = trouble;
}
