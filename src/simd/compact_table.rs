//! A table of permutations for the compaction of lanes.

/// For each set of lanes, the permutation that moves its lanes to the end, one byte per lane. The
/// table has 2 KiB. A smaller one would take one more instruction to expand; a larger one would
/// evict the tree from the L1 cache.
pub static COMPACT_LANES: [u64; 256] = {
    let mut table = [0; 256];
    let mut set = 0;
    while set < 256 {
        let (mut place, mut lane) = (8, 8);
        while lane > 0 {
            lane -= 1;
            if set >> lane & 1 == 1 {
                place -= 1;
                table[set] |= (lane as u64) << (8 * place);
            }
        }
        set += 1;
    }
    table
};
