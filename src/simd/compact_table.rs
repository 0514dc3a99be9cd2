//! How the lanes of a set are moved together.

/// For each set of lanes the lanes in it, a byte each, the highest at the end: what moves them together. Two KiB: less would
/// take an instruction more to spread, more would drive the tree from the first cache.
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
