//! How the lanes of a set are moved together.

/// For each set of lanes the lanes in it, four bits each, the highest at the end: what moves them together. One KiB, so that
/// it does not drive the tree from the first cache.
pub static TOGETHER: [u32; 256] = {
    let mut table = [0; 256];
    let mut set = 0;
    while set < 256 {
        let (mut place, mut lane) = (8, 8);
        while lane > 0 {
            lane -= 1;
            if set >> lane & 1 == 1 {
                place -= 1;
                table[set] |= (lane as u32) << (4 * place);
            }
        }
        set += 1;
    }
    table
};
