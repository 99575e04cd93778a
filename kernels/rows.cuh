// Rows of the list as forces read them, and the inner list that forces make of it.

// Entries that are read once a step: they are not to drive out of the caches what is read again and again. They stay as they
// come until they are needed: taking them apart would wait for them.
union Words {
    Chunk chunk;
    u32 word[sizeof(Chunk) / 4];
};

__device__ __forceinline__ Words stream(const Chunk* from) {
    Words to;
    for (u32 k = 0; k < sizeof(Chunk) / 16; k++) {
        const uint4 four = __ldcs((const uint4*)from + k);
        to.word[4 * k] = four.x, to.word[4 * k + 1] = four.y, to.word[4 * k + 2] = four.z, to.word[4 * k + 3] = four.w;
    }
    return to;
}

// In a large scene every slot is read by many rows, those of the next layers of cells too, while more than the second-level cache
// holds passes by that is read once: slots are then the last to leave it (LASTING), which costs an instruction a neighbor.
#if defined(LASTING) && __CUDA_ARCH__ < 800
#undef LASTING
#endif

// What neighbors are read with.
__device__ __forceinline__ u64 lasting() {
    u64 policy = 0;
#if defined(LASTING) && __CUDA_ARCH__ == 900
    // What the instruction below makes there. As a constant it needs no registers that have to be copied for every read.
    policy = 0x14f0000000000000ull;
#elif defined(LASTING)
    asm volatile("createpolicy.fractional.L2::evict_last.b64 %0, 1.0;" : "=l"(policy));
#endif
    return policy;
}

#ifdef LASTING
#define READ "ld.global.L2::cache_hint"
#define WITH(policy) ", " policy ";"
#else
#define READ "ld.global"
#define WITH(policy) ";"
#endif

// A neighbor's slot; `slots` is an address in a register, not something to be worked out for each of them. One read: not all of it
// may be asked for.
__device__ __forceinline__ Slot gather(const Slot* slots, u32 place, u64 policy) {
    asm volatile("" : "+l"(slots));
    const Slot* from = slots + place;
    Slot q;
#ifdef FIXED
    asm volatile(READ ".v4.s32 {%0, %1, %2, %3}, [%4]" WITH("%5") : "=r"(q.x), "=r"(q.y), "=r"(q.z), "=r"(q.w) : "l"(from), "l"(policy) : "memory");
#else
    asm volatile(READ ".v2.f64 {%0, %1}, [%2]" WITH("%3") : "=d"(q.x), "=d"(q.y) : "l"(from), "l"(policy) : "memory");
    asm volatile(READ ".v2.f64 {%0, %1}, [%2 + 16]" WITH("%3") : "=d"(q.z), "=d"(q.w) : "l"(from), "l"(policy) : "memory");
#endif
    return q;
}

// Into the second-level cache.
__device__ __forceinline__ void prefetch(const Chunk* row) { asm volatile("prefetch.global.L2 [%0];" ::"l"(row)); }

// The entry number m, as it is stored and in full.
__device__ __forceinline__ Stored stored_of(const Words& words, u32 m) {
#ifdef SHORT
    const u32 word = words.word[m / 2];
    return (Stored)(m % 2 == 0 ? word : word >> 16);
#else
    return words.chunk.entry[m];
#endif
}

#ifdef SHORT
// Each thread's own copy of the runs that its particle sees, apart by 32: in a bank of its own, so that a look-up is one access
// whatever the particles of a warp see.
#define RUN_BYTES (32 * (u32)sizeof(u32))
#endif

// Where a thread's copy begins in shared memory. Where a run lies in it is but a few bits of that address, all zero here.
__device__ __forceinline__ u32 own_runs() {
#ifdef SHORT
    // Room to begin at a multiple of a warp's part: what the compiler aligns it to is not that of the address.
    const u32 part = RUNS * RUN_BYTES;
    __shared__ u32 copies[BLOCK / 32 + 1][RUNS][32];
    return (shared_address(copies) + part - 1) / part * part + threadIdx.x / 32 * part + threadIdx.x % 32 * (u32)sizeof(u32);
#else
    return 0;
#endif
}

__device__ __forceinline__ void copy_runs(const Arrays& a, u32 i, u32 own) {
#ifdef SHORT
    const uint4* seen = (const uint4*)runs_of(a, a.homes[i]);
    for (u32 k = 0; k < RUNS / 4; k++) {
        const uint4 four = seen[k];
        const u32 of[4] = {four.x, four.y, four.z, four.w};
        for (u32 m = 0; m < 4; m++) asm volatile("st.shared.u32 [%0], %1;" ::"r"(own | (4 * k + m) * RUN_BYTES), "r"(of[m]));
    }
#endif
}

__device__ __forceinline__ Entry entry_of(const Words& words, u32 m, u32 own) {
#ifdef SHORT
    const u32 word = words.word[m / 2], stored = m % 2 == 0 ? word & 0xffff : word >> 16;
    // The run's number times RUN_BYTES out of the word in one shift.
    const u32 run = word >> (m % 2 * 16 + PLACE_BITS - 7) & (RUNS - 1) * RUN_BYTES;
    static_assert(RUN_BYTES == 1 << 7 && PLACE_BITS >= 7, "the shift is for other lengths");
    u32 begin;
    asm volatile("ld.shared.u32 %0, [%1];" : "=r"(begin) : "r"(own | run));
    return begin + stored;
#else
    return words.chunk.entry[m];
#endif
}

// Which list is read.
enum From {
    LIST,  // the list as it was built
    PRUNE, // the same, and what of it is near enough goes into the inner list
    NEAR,  // the inner list
};

#ifdef INNER
// The part of a row that a thread has, as it goes into the inner list: entries wait until they fill a chunk. There is room for
// the words of two chunks, apart by 32: each thread has a bank of its own.
struct Kept {
    u32* wait;
    u32 count, written;
};

__device__ __forceinline__ Kept kept_none() {
    __shared__ u32 wait[BLOCK / 32][2 * sizeof(Chunk) / 4][32];
    Kept k = {&wait[threadIdx.x / 32][0][threadIdx.x % 32], 0, 0};
    return k;
}

// Where the next entry goes one that is not near may stand for nothing.
__device__ __forceinline__ void keep(Kept& k, Stored entry, bool near) {
    const u32 place = k.count % (2 * CHUNK);
#ifdef SHORT
    ((Stored*)(k.wait + place / 2 * 32))[place % 2] = entry;
#else
    const u32 words = sizeof(Stored) / 4;
    for (u32 m = 0; m < words; m++) k.wait[(place * words + m) * 32] = (u32)((u64)entry >> 32 * m);
#endif
    k.count += near;
}

// A chunk leaves where there is one; `to` is where the thread's first one goes, `apart` from the next.
__device__ __forceinline__ void write_kept(Kept& k, Chunk* to, u64 apart) {
    if (k.count - k.written < CHUNK) return;
    Words words;
    const u32 first = k.written / CHUNK % 2 * (sizeof(Chunk) / 4);
    for (u32 m = 0; m < sizeof(Chunk) / 4; m++) words.word[m] = k.wait[(first + m) * 32];
    to[k.written / CHUNK * apart] = words.chunk;
    k.written += CHUNK;
}

// The end of a row: what still waits leaves too. A chunk is filled up with an entry of the row, which names a particle.
__device__ __forceinline__ void end_kept(Kept& k, Stored filler, Chunk* to, u64 apart) {
    while (k.count % CHUNK != 0) keep(k, filler, true);
    write_kept(k, to, apart);
}
#endif

// The inner list, and how much of a row each thread has there. A scene without one reads neither.
__device__ __forceinline__ Chunk* inner_of(const Arrays& a) {
#ifdef INNER
    return a.inner;
#else
    return nullptr;
#endif
}

__device__ __forceinline__ u32* kept_by(const Arrays& a, const Scene& s, u32 lane) {
#ifdef INNER
    return a.kept + lane * s.pitch;
#else
    return nullptr;
#endif
}
