// Distances by matrix products, and rows of the list as they come out of them. Squared distances of 32 candidates from all
// particles of a group are |i|^2 - 2 i j + |j|^2 in half precision, every number as the sum of two or three, which is exact to
// the rounding of single precision. What rounding could decide is worked out anew, in double precision if need be. Neighbors are
// gathered in shared memory, row by row, and leave it in chunks.
//
// Row i of the list has neighbors[i] entries; entry k stands at ((k / CHUNK) * pitch + i) * CHUNK + k % CHUNK, so that a chunk
// is read at once and chunks of neighboring rows stand side by side. An entry is the neighbor's place and, in the bits above
// INDEX_BITS, the number of the periodic image it is seen in. A short one is stored as its place in a run of sorted particles
// and, in the bits above PLACE_BITS, the number of the run among those that the octant sees.

// Whether an entry is a neighbor of i: decided in double precision, with LAMMPS's rounding across a side.
__device__ __noinline__ bool is_neighbor(const Arrays& a, const Scene& s, const Run& r, u32 i, Entry entry, double limit) {
    const u32 j = place_of(entry);
#ifdef IMAGES
    u32 code = (u32)(entry >> INDEX_BITS);
#endif
    double xi[3], xj[3], image[3];
    for (u32 axis = 0; axis < 3; axis++) {
        const double* x = axis_of(side_of(a.held_x, s, r.parity, 3), s, axis);
        xi[axis] = x[i];
        xj[axis] = x[j];
#ifdef IMAGES
        const u32 images = 2 * s.images[axis] + 1;
        image[axis] = (double)((int)(code % images) - s.images[axis]);
        code /= images;
#else
        // Coordinates go around with the box: the nearest image is the only one in reach.
        image[axis] = PERIODIC >> axis & 1 ? rint((xi[axis] - xj[axis]) / s.lengths[axis]) : 0.0;
#endif
    }
    double held;
    hold(xi, xj, image, s, limit, &held);
    return held != 0.0;
}

// Particles of a matrix product, and products for a group.
#define TILE 16
#define TILES ((GROUP + TILE - 1) / TILE)
// The part of a sum's largest term by which it may be off: products of halves are exact, at most 17 numbers are added, each
// cut off after 23 bits; coordinates have 22 bits, with two types norms of candidates too.
#define TENSOR_ERROR 6.5e-6f
// Entries of a row that wait in shared memory, and more so that rows begin in different banks.
#define ROOM (sizeof(Stored) == 8 ? 32 : 64)
#define ROW (ROOM + CHUNK)

// Types whose cutoffs fit into a matrix: two types into columns that are there anyway, more into one of their own, a word of two
// halves each. With more than that every pair is tested exactly.
#if defined(CUTOFFS) && TYPES == 2
#define TWO_CUTOFFS
#elif defined(CUTOFFS) && TYPES <= 8
#define BY_TYPE
#endif
// One in both halves of a word.
#define ONES 0x3c003c00u

// Rows that are written side by side.
#define AT_ONCE 8

// A warp's part of the shared memory.
struct Bench {
    // Candidates that wait, as rows of a matrix of halves: in two parts, for sixteen columns.
    uint4 left[64], right[64];
    Stored entry[64];
#ifdef BY_TYPE
    unsigned char kind[64];
#endif
    __align__(16) Stored rows[TILES * TILE][ROW];
    // Bits of the candidates that are neighbors, and the address of their first entry, by row.
    uint2 found[TILES * TILE];
    u32 order[32];
    // The first particle as an entry of its own row; the others follow.
    Stored self;
};

__device__ __forceinline__ float3 relative(const int4& q, const int4& from, const float unit[3]) {
    return make_float3((float)(q.x - from.x) * unit[0], (float)(q.y - from.y) * unit[1], (float)(q.z - from.z) * unit[2]);
}

__device__ __forceinline__ int least_of(int x) {
#if __CUDA_ARCH__ >= 800
    return __reduce_min_sync(~0u, x);
#else
    for (u32 d = 16; d > 0; d >>= 1) x = min(x, __shfl_xor_sync(~0u, x, d));
    return x;
#endif
}

__device__ __forceinline__ u32 bits_of_all(u32 bits) {
#if __CUDA_ARCH__ >= 800
    return __reduce_or_sync(~0u, bits);
#else
    for (u32 d = 16; d > 0; d >>= 1) bits |= __shfl_xor_sync(~0u, bits, d);
    return bits;
#endif
}

__device__ __forceinline__ u32 half_of(float x) {
    unsigned short h;
    asm("cvt.rn.f16.f32 %0, %1;" : "=h"(h) : "f"(x));
    return h;
}

__device__ __forceinline__ float float_of(u32 h) {
    float x;
    asm("cvt.f32.f16 %0, %1;" : "=f"(x) : "h"((unsigned short)h));
    return x;
}

// A number as the sum of two halves, which stand in the halves of a word.
__device__ __forceinline__ u32 halves_of(float x) {
    const u32 high = half_of(x);
    return half_of(x - float_of(high)) << 16 | high;
}

__device__ __forceinline__ void put(u32 at, u32 entry, u32 there) {
    asm volatile("{\n.reg .pred p;\nsetp.ne.u32 p, %2, 0;\n@p st.shared.u32 [%0], %1;\n}" ::"r"(at), "r"(entry), "r"(there) : "memory");
}
__device__ __forceinline__ void put(u32 at, unsigned short entry, u32 there) {
    asm volatile("{\n.reg .pred p;\nsetp.ne.u32 p, %2, 0;\n@p st.shared.u16 [%0], %1;\n}" ::"r"(at), "h"(entry), "r"(there) : "memory");
}
__device__ __forceinline__ void put(u32 at, u64 entry, u32 there) {
    asm volatile("{\n.reg .pred p;\nsetp.ne.u32 p, %2, 0;\n@p st.shared.u64 [%0], %1;\n}" ::"r"(at), "l"(entry), "r"(there) : "memory");
}

// Columns of the matrices, with x = X + x' as two halves and norms as three:
//
//              left half of a row                  right half
//   particle   -2X -2X -2Y -2Y -2Z -2Z   1   1     -2x' -2y' -2z'   1   n   n'  n''   0     n = |i|^2 less the squared cutoff
//   candidate    X  x'   Y  y'   Z  z'   N  N'       X    Y    Z   N''  1   1    1    0     N = |j|^2
//
// The product of two rows is |i - j|^2 less the squared cutoff, but for x' x' and the like, which are below the rounding.
//
// Where two types differ in cutoffs, n has that with the first type, by how much that with the second is smaller stands as two
// halves where 1 meets N'' and 0 meets 0, and the candidate has 1 there, twice, if it is of the second type, 0 if not.
__device__ __forceinline__ u32 third_half(float x, u32 two) { return half_of(x - float_of(two & 0xffff) - float_of(two >> 16)); }

// Rows of the group's particles, a thread a row; those without a particle are far from everything.
__device__ __forceinline__ void write_particle(Bench& w, u32 row, const float3& x, bool there, float squared_cutoff, float less) {
    const float norm = there ? x.x * x.x + x.y * x.y + x.z * x.z - squared_cutoff : 3e4f;
    const u32 hx = halves_of(-2 * x.x), hy = halves_of(-2 * x.y), hz = halves_of(-2 * x.z), hn = halves_of(norm);
    w.left[row] = make_uint4(__byte_perm(hx, 0, 0x1010), __byte_perm(hy, 0, 0x1010), __byte_perm(hz, 0, 0x1010), ONES);
#ifdef TWO_CUTOFFS
    const u32 hl = halves_of(less), last = hl & 0xffff0000u;
#else
    const u32 hl = ONES, last = 0;
#endif
    w.right[row] = make_uint4(__byte_perm(hx, hy, 0x7632), __byte_perm(hz, hl, 0x5432), hn, third_half(norm, hn) | last);
}

// A candidate's row.
__device__ __forceinline__ void write_candidate(Bench& w, u32 row, const float3& x, int kind) {
    const float norm = x.x * x.x + x.y * x.y + x.z * x.z;
    const u32 hx = halves_of(x.x), hy = halves_of(x.y), hz = halves_of(x.z), hn = halves_of(norm);
    w.left[row] = make_uint4(hx, hy, hz, hn);
#ifdef TWO_CUTOFFS
    const u32 second = kind != 0 ? ONES : 0, fourth = second, last = second & 0xffff0000u;
#else
    const u32 fourth = third_half(norm, hn), last = 0;
#endif
    w.right[row] = make_uint4(__byte_perm(hx, hy, 0x5410), __byte_perm(hz, fourth, 0x5410), ONES, (ONES & 0xffff) | last);
}

// Four matrices of 8 x 8 halves, from rows whose addresses the threads have.
__device__ __forceinline__ void load_matrices(const void* row, u32 m[4]) {
    asm volatile("ldmatrix.sync.aligned.m8n8.x4.shared.b16 {%0, %1, %2, %3}, [%4];"
                 : "=r"(m[0]), "=r"(m[1]), "=r"(m[2]), "=r"(m[3]) : "r"(shared_address(row)) : "memory");
}

// d = a b for 16 particles with 8 candidates; a thread has rows lane / 4 and lane / 4 + 8, columns 2 (lane % 4) and the next.
__device__ __forceinline__ void multiply(float d[4], const u32 a[4], const u32 b[2]) {
    const float zero = 0.0f;
#if __CUDA_ARCH__ >= 800
    asm("mma.sync.aligned.m16n8k16.row.col.f32.f16.f16.f32 {%0, %1, %2, %3}, {%4, %5, %6, %7}, {%8, %9}, {%10, %10, %10, %10};"
        : "=f"(d[0]), "=f"(d[1]), "=f"(d[2]), "=f"(d[3]) : "r"(a[0]), "r"(a[1]), "r"(a[2]), "r"(a[3]), "r"(b[0]), "r"(b[1]), "f"(zero));
#else
    asm("mma.sync.aligned.m16n8k8.row.col.f32.f16.f16.f32 {%0, %1, %2, %3}, {%4, %5}, {%6}, {%7, %7, %7, %7};"
        : "=f"(d[0]), "=f"(d[1]), "=f"(d[2]), "=f"(d[3]) : "r"(a[0]), "r"(a[1]), "r"(b[0]), "f"(zero));
    asm("mma.sync.aligned.m16n8k8.row.col.f32.f16.f16.f32 {%0, %1, %2, %3}, {%4, %5}, {%6}, {%0, %1, %2, %3};"
        : "+f"(d[0]), "+f"(d[1]), "+f"(d[2]), "+f"(d[3]) : "r"(a[2]), "r"(a[3]), "r"(b[1]));
#endif
}

#ifdef BY_TYPE
// d += a b.
__device__ __forceinline__ void multiply_add(float d[4], const u32 a[4], const u32 b[2]) {
#if __CUDA_ARCH__ >= 800
    asm("mma.sync.aligned.m16n8k16.row.col.f32.f16.f16.f32 {%0, %1, %2, %3}, {%4, %5, %6, %7}, {%8, %9}, {%0, %1, %2, %3};"
        : "+f"(d[0]), "+f"(d[1]), "+f"(d[2]), "+f"(d[3]) : "r"(a[0]), "r"(a[1]), "r"(a[2]), "r"(a[3]), "r"(b[0]), "r"(b[1]));
#else
    for (u32 k = 0; k < 2; k++)
        asm("mma.sync.aligned.m16n8k8.row.col.f32.f16.f16.f32 {%0, %1, %2, %3}, {%4, %5}, {%6}, {%0, %1, %2, %3};"
            : "+f"(d[0]), "+f"(d[1]), "+f"(d[2]), "+f"(d[3]) : "r"(a[2 * k]), "r"(a[2 * k + 1]), "r"(b[k]));
#endif
}
#endif

// What a group has in registers.
struct Group {
    u32 first_i, m;
    u32 lane;
    u32 particles[TILES][4]; // matrices
#ifdef BY_TYPE
    u32 cutoffs[TILES][4]; // by how much the squared cutoffs with each type are below the largest, as matrices
#endif
    float band;              // within which rounding could decide
    u32 mine;                // the row this thread writes out
    u32 fill, done;          // its entries that wait, and chunks that have left
};

// Rows of which a thread has results are lane / 4 + 8 k; it writes out that with k = lane % 4.
__device__ __forceinline__ u32 row_of(u32 lane) { return (lane >> 2) + 8 * (lane & 3); }

// The candidate that bit `lane` of a row stands for.
__device__ __forceinline__ u32 column_of(u32 lane) {
    const u32 place = 31 - lane, n = place & 7;
    return (n >> 1) * 8 + 2 * (place >> 3) + (n & 1);
}

// And the other way around.
__device__ __forceinline__ u32 lane_of(u32 column) { return 31 - ((column >> 1 & 3) * 8 + (column >> 3) * 2 + (column & 1)); }

// An entry of the group's rows in full.
__device__ __forceinline__ Entry entry_in(const Arrays& a, const Group& g, Stored stored) {
#ifdef SHORT
    return entry_of(stored, runs_of(a, a.homes[g.first_i]));
#else
    return stored;
#endif
}

// Whole chunks leave shared memory; with LAST all that is left, filled up with entries that are no neighbors.
template <bool LAST> __device__ __forceinline__ void write_chunks(const Arrays& a, const Scene& s, Bench& w, Group& g) {
    __syncwarp();
    Stored* row = w.rows[g.mine];
    if (LAST && g.fill > 0)
        for (u32 k = g.fill; k % CHUNK != 0; k++) row[k] = w.self + g.mine;
    const u32 chunks = (LAST ? g.fill + CHUNK - 1 : g.fill) / CHUNK;
    Chunk* to = a.list + (u64)g.done * s.pitch + g.first_i + g.mine;
    for (u32 c = 0; c < chunks; c++, to += s.pitch)
        if ((g.done + c) * CHUNK < s.capacity) *to = *(const Chunk*)(row + c * CHUNK);
    if (!LAST) {
        if (chunks > 0) *(Chunk*)row = *(const Chunk*)(row + chunks * CHUNK);
        g.fill %= CHUNK;
        g.done += chunks;
        __syncwarp();
    }
}

// Whether an entry is a neighbor of particle i, exactly.
__device__ __noinline__ bool test_exactly(const Arrays& a, const Scene& s, const Run& r, u32 i, Entry entry) {
    const u32 j = place_of(entry);
    const int4 own = a.fixed[i];
    int4 q = a.fixed[j];
#ifdef IMAGES
    const int4 shift = a.fixed_shifts[entry >> INDEX_BITS];
    q.x += shift.x, q.y += shift.y, q.z += shift.z;
#endif
    const float3 d = relative(q, own, s.scale);
    const float r2 = d.x * d.x + d.y * d.y + d.z * d.z;
#if TYPES > 1
    const Limit limit = a.limits[(u32)own.w * TYPES + (u32)q.w];
#else
    const Limit limit = a.limits[0];
#endif
    if (!(r2 <= limit.outer)) return false;
    return r2 < limit.inner || is_neighbor(a, s, r, i, entry, limit.squared);
}

// Tests `found` candidates that wait from `base` on against the group; `own` is the number of its first particle among them.
__device__ __forceinline__ void test_candidates(const Arrays& a, const Scene& s, const Run& r, Bench& w, Group& g, u32 base, u32 found, u32 own) {
    // Eight bits of each row, the first candidate's on top.
    u32 bits[4] = {0, 0, 0, 0};
    float least = 3e38f;
#pragma unroll
    for (u32 pair = 0; pair < 2; pair++) {
        // Two times eight candidates.
        const u32 row = base + pair * 16 + (g.lane >> 4) * 8 + (g.lane & 7);
        u32 b[4];
        load_matrices(g.lane & 8 ? &w.right[row] : &w.left[row], b);
#pragma unroll
        for (u32 n = 0; n < 2; n++)
#pragma unroll
            for (u32 t = 0; t < TILES; t++) {
                float d[4];
                multiply(d, g.particles[t], b + 2 * n);
#ifdef BY_TYPE
                // Ones for the candidate's type.
                const u32 kind = w.kind[base + pair * 16 + n * 8 + (g.lane >> 2)];
                const u32 is[2] = {kind == (g.lane & 3) ? ONES : 0, kind == (g.lane & 3) + 4 ? ONES : 0};
                multiply_add(d, g.cutoffs[t], is);
#endif
#pragma unroll
                for (u32 k = 0; k < 4; k++) {
                    bits[2 * t + k / 2] = __funnelshift_l(__float_as_uint(d[k]), bits[2 * t + k / 2], 1);
                    least = fminf(least, fabsf(d[k]));
                }
            }
    }
    // The four threads that have bytes of four rows go over to a whole row each.
    u32 row = bits[0] | bits[1] << 8 | bits[2] << 16 | bits[3] << 24;
    row = __byte_perm(row, __shfl_xor_sync(~0u, row, 1), g.lane & 1 ? 0x3715 : 0x6240);
    row = __byte_perm(row, __shfl_xor_sync(~0u, row, 2), g.lane & 2 ? 0x6723 : 0x0145);
    const u32 column = column_of(g.lane);
    const Stored entry = w.entry[base + column];
    if (__any_sync(~0u, least <= g.band)) {
        row = 0;
        if (g.mine < g.m)
#pragma unroll 1
            for (u32 n = 0; n < 32; n++)
                if (column_of(n) < found) row |= (u32)test_exactly(a, s, r, g.first_i + g.mine, entry_in(a, g, w.entry[base + column_of(n)])) << n;
    }
    if (found < 32) row &= __ballot_sync(~0u, column < found);
    // Particles of the group come one after the other.
    if (own + g.mine < 32) row &= ~(1u << lane_of(own + g.mine));
    if (g.mine < TILES * TILE) w.found[g.mine] = make_uint2(row, shared_address(&w.rows[g.mine][g.fill]));
    g.fill += __popc(row);
    __syncwarp();
    // A row after the other, a thread a candidate; what several rows need is read before the first of them is written.
    const u32 bit = 1u << g.lane, below = bit - 1;
#pragma unroll 1
    for (u32 k = 0; k < g.m; k += AT_ONCE) {
        uint2 of[AT_ONCE];
#pragma unroll
        for (u32 l = 0; l < AT_ONCE; l++) of[l] = w.found[k + l];
#pragma unroll
        for (u32 l = 0; l < AT_ONCE; l++) put(of[l].y + __popc(of[l].x & below) * (u32)sizeof(Stored), entry, of[l].x & bit);
    }
    if (__any_sync(~0u, g.fill > ROW - 32)) write_chunks<false>(a, s, w, g);
}

