//! How the lanes of a set are moved together.

/// For each set of lanes the lanes in it, lowest first, four bits each: what moves them together. One KiB, so that it
/// does not drive the tree from the first cache.
pub static TOGETHER: [u32; 256] = {
    let mut table = [0; 256];
    let mut set = 0;
    while set < 256 {
        let (mut n, mut lane) = (0, 0);
        while lane < 8 {
            if set >> lane & 1 == 1 {
                table[set] |= (lane as u32) << (4 * n);
                n += 1;
            }
            lane += 1;
        }
        set += 1;
    }
    table
};
