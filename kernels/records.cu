// What a launch has recorded, added up over the blocks of `advance_recording`: a block a record.

extern "C" __global__ void __launch_bounds__(BLOCK) sum_records(const __grid_constant__ Arrays a, const __grid_constant__ Scene s, const __grid_constant__ Order o) {
    const u32 recorded = a.control->recorded, blocks = a.control->record_blocks;
    for (u32 k = blockIdx.x; k < recorded; k += gridDim.x) add_blocks(a.record_sums + (u64)k * blocks * SUMS, blocks, a.records + k * SUMS);
}
