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

#ifdef SHORT
// Runs that the particles of an octant see: of each the entry for its first particle, less the stored one. A stored entry is then
// in full what stands here plus all of its bits.
__device__ __forceinline__ u32* runs_of(const Arrays& a, u32 home) { return a.runs + (u64)home * RUNS; }

__device__ __forceinline__ Entry entry_of(u32 stored, const u32* runs) { return runs[stored >> PLACE_BITS] + stored; }
#endif

__device__ __forceinline__ u32 shared_address(const void* p) {
    u64 address;
    asm("cvta.to.shared.u64 %0, %1;" : "=l"(address) : "l"(p));
    return (u32)address;
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
    u32 turn; // of the two words of the barrier
    u64 met, met_before; // what they stood at when all had arrived: the one that is next, and the other
    i64 step;
    u64 ago;
    u64 builds;
    u64 dangerous;
    i64 next_sort;
    u64 clock; // first thread only
};

// All threads of the grid wait here for each other; what was written before is seen after. The grid is resident as a whole
// (cooperative launch). Returns whether any of them came with a mark. Arrivals are counted in the lower half of a word, blocks
// that came with a mark in the upper one: no memory has to be read once more to know. Two words take turns, as a block may
// arrive for the next time before another has seen that all had arrived for this one.
__device__ __forceinline__ bool sync_grid(const Arrays& a, Run& r, bool mark = false) {
    __shared__ u64 all;
    const int marked = __syncthreads_or(mark);
    if (threadIdx.x == 0) {
        u64* word = &a.control->barrier[r.turn];
        const u32 wanted = (u32)r.met + gridDim.x;
        u64 now;
        asm volatile("fence.acq_rel.gpu;" ::: "memory");
        asm volatile("red.relaxed.gpu.global.add.u64 [%0], %1;" :: "l"(word), "l"(marked ? (1ull << 32) + 1 : 1ull) : "memory");
        do asm volatile("ld.relaxed.gpu.global.u64 %0, [%1];" : "=l"(now) : "l"(word) : "memory");
        while ((u32)now != wanted);
        asm volatile("fence.acq_rel.gpu;" ::: "memory");
        all = now;
    }
    __syncthreads();
    const u64 now = all;
    const bool any = (now ^ r.met) >> 32 != 0;
    r.turn ^= 1;
    r.met = r.met_before;
    r.met_before = now;
    return any;
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

// Where the last kernel left off, but for the barrier.
__device__ __forceinline__ void read_run(const Arrays& a, Run& r) {
    const Control* c = a.control;
    r.n = c->n, r.parity = c->parity, r.half_done = c->half_done;
    r.step = c->step, r.ago = c->ago, r.builds = c->builds, r.dangerous = c->dangerous, r.next_sort = c->next_sort;
}

// Where the last kernel left off. All threads of the grid have read it when this returns.
__device__ __forceinline__ Run begin_run(const Arrays& a) {
    Run r;
    read_run(a, r);
    const Control* c = a.control;
    r.turn = c->turn, r.met = c->met[r.turn], r.met_before = c->met[r.turn ^ 1], r.clock = 0;
    sync_grid(a, r);
    book(a, r, STAGE_OTHER);
    return r;
}

__device__ __forceinline__ void end_run(const Arrays& a, const Run& r, u64 left, u32 begin, u32 trouble) {
    if (THREAD != 0) return;
    Control* c = a.control;
    c->parity = r.parity;
    c->half_done = r.half_done;
    c->turn = r.turn;
    c->met[r.turn] = r.met;
    c->met[r.turn ^ 1] = r.met_before;
    c->step = r.step;
    c->ago = r.ago;
    c->builds = r.builds;
    c->dangerous = r.dangerous;
    c->next_sort = r.next_sort;
    c->left = left;
    c->begin = begin;
    c->trouble = trouble;
}
