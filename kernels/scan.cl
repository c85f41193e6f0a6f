// Exclusive prefix sum of uint counts, in three steps (host/device/scan.cpp): the sum of each chunk, a scan
// of these few sums on the host, and the chunks again with their offsets. A kernel of its own because every
// stream compaction and every numbering needs it.
//
// Work mapping: one chunk of consecutive values per work-item where a work-item is a core's own loop
// (LANES > 1), else one chunk per work-group, whose items read neighbouring values and add up in local
// memory. Integer sums, so both give the same bits. SUM is the type of the result, uint or ulong.

#if LANES > 1

// Reads values[0, count); writes sums[0, items).
MORTISE_KERNEL void scan_sums(global const uint* values, global ulong* sums, ulong chunk, ulong count,
                              uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    const ulong begin = item * chunk;
    const ulong end = min(begin + chunk, count);
    ulong sum = 0;
    for (ulong i = begin; i < end; ++i) sum += values[i];
    sums[item] = sum;
}

// Reads values[0, count) and offsets[0, items); writes out[0, count]. out may be values: each value is read
// before its place is written.
MORTISE_KERNEL void scan_fill(global const uint* values, global SUM* out, global const ulong* offsets,
                              ulong chunk, ulong count, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    const ulong begin = item * chunk;
    const ulong end = min(begin + chunk, count);
    SUM sum = (SUM)offsets[item];
    for (ulong i = begin; i < end; ++i) {
        const uint value = values[i];
        out[i] = sum;
        sum += value;
    }
    if (end == count) out[count] = sum;
}

#else

// As above; items = chunks × MORTISE_WORK_GROUP, so every group is whole and meets its barriers together.
MORTISE_KERNEL void scan_sums(global const uint* values, global ulong* sums, ulong chunk, ulong count,
                              uint items) {
    local ulong partial[MORTISE_WORK_GROUP];
    const uint lane = get_local_id(0);
    const ulong begin = get_group_id(0) * chunk;
    const ulong end = min(begin + chunk, count);
    ulong sum = 0;
    for (ulong i = begin + lane; i < end; i += MORTISE_WORK_GROUP) sum += values[i];
    partial[lane] = sum;
    barrier(CLK_LOCAL_MEM_FENCE);
    for (uint width = MORTISE_WORK_GROUP; width > 1;) {
        const uint half_width = (width + 1) / 2;
        if (lane + half_width < width) partial[lane] += partial[lane + half_width];
        barrier(CLK_LOCAL_MEM_FENCE);
        width = half_width;
    }
    if (lane == 0) sums[get_group_id(0)] = partial[0];
}

MORTISE_KERNEL void scan_fill(global const uint* values, global SUM* out, global const ulong* offsets,
                              ulong chunk, ulong count, uint items) {
    local SUM partial[MORTISE_WORK_GROUP];
    const uint lane = get_local_id(0);
    const ulong begin = get_group_id(0) * chunk;
    const ulong end = min(begin + chunk, count);
    SUM before = (SUM)offsets[get_group_id(0)];
    for (ulong tile = begin; tile < end; tile += MORTISE_WORK_GROUP) {
        const ulong i = tile + lane;
        const SUM value = i < end ? values[i] : 0;
        partial[lane] = value;
        barrier(CLK_LOCAL_MEM_FENCE);
        for (uint reach = 1; reach < MORTISE_WORK_GROUP; reach *= 2) {  // inclusive, after Hillis and Steele
            const SUM addend = lane >= reach ? partial[lane - reach] : 0;
            barrier(CLK_LOCAL_MEM_FENCE);
            partial[lane] += addend;
            barrier(CLK_LOCAL_MEM_FENCE);
        }
        if (i < end) out[i] = before + partial[lane] - value;
        before += partial[MORTISE_WORK_GROUP - 1];
        barrier(CLK_LOCAL_MEM_FENCE);
    }
    if (lane == 0 && end == count) out[count] = before;
}

#endif
