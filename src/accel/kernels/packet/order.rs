//! The rays of a batch that form a packet.

use crate::accel::kernels::ray16::RAYS;

/// The layout of a packet's rays in the batch: rows of two to the power of `run` rays, at a
/// distance of two to the power of `stride`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PacketOrder {
    run: u32,
    stride: u32,
    /// The offset of each ray from the packet's first one.
    steps: [u32; RAYS],
}

/// The indices of up to [`RAYS`] rays; the last index is repeated if there are fewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PacketRays {
    pub ids: [u32; RAYS],
    pub len: usize,
}

impl PacketOrder {
    /// Packets of sixteen consecutive rays.
    pub const ROWS: Self = Self::new(4, 4);

    const fn new(run: u32, stride: u32) -> Self {
        let mut steps = [0; RAYS];
        let mut k = 0;
        while k < RAYS {
            steps[k] = ((k >> run << stride) + (k & ((1 << run) - 1))) as u32;
            k += 1;
        }
        Self { run, stride, steps }
    }

    /// Packets of two rows of eight rays, or four rows of four: blocks of an image tile whose rows
    /// have `stride` rays, a power of two and at least eight.
    pub fn blocks(run: usize, stride: usize) -> Self {
        debug_assert!((run == 4 || run == 8) && stride.is_power_of_two() && stride >= 8);
        Self::new(run.trailing_zeros(), stride.trailing_zeros())
    }

    /// Returns the number of consecutive rays that form whole packets.
    pub fn band(&self) -> usize {
        RAYS << self.stride >> self.run
    }

    /// Returns the rays of a packet in a batch of `count` rays.
    #[inline(always)]
    pub fn list(&self, packet: usize, count: usize) -> PacketRays {
        let (first, band) = (packet * RAYS, self.band());
        let start = first & !(band - 1);
        let ids = if start + band <= count {
            let start = (start + ((first - start) >> 4 << self.run)) as u32;
            self.steps.map(|step| start + step)
        } else {
            std::array::from_fn(|k| (first + k).min(count - 1) as u32)
        };
        PacketRays {
            ids,
            len: count.saturating_sub(first).min(RAYS),
        }
    }
}

impl PacketRays {
    /// Returns the rays whose bits are set in `lanes`.
    pub fn only(&self, lanes: u32) -> Self {
        let mut list = Self { len: 0, ..*self };
        for (_, &id) in (0..RAYS).zip(&self.ids).filter(|(k, _)| lanes >> k & 1 == 1) {
            list.ids[list.len..].fill(id);
            list.len += 1;
        }
        list
    }

    pub fn as_slice(&self) -> &[u32] {
        &self.ids[..self.len]
    }

    /// Returns the set of used lanes.
    pub fn lanes(&self) -> u32 {
        (1 << self.len) - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_ray_is_in_one_packet() {
        for order in [
            PacketOrder::ROWS,
            PacketOrder::blocks(4, 16),
            PacketOrder::blocks(8, 32),
            PacketOrder::blocks(4, 8),
        ] {
            for count in [1_usize, 15, 16, 100, 256, 300] {
                let lists = (0..count.div_ceil(RAYS)).map(|packet| order.list(packet, count));
                let mut listed: Vec<u32> = lists.flat_map(|list| list.as_slice().to_vec()).collect();
                listed.sort_unstable();
                assert!(listed.into_iter().eq(0..count as u32), "{order:?} {count}");
            }
        }
    }

    #[test]
    fn blocks_are_blocks() {
        let list = PacketOrder::blocks(4, 16).list(5, 256);
        assert_eq!(list.ids[..6], [68, 69, 70, 71, 84, 85]);
        let some = list.only(0b10_0010);
        assert_eq!((some.as_slice(), some.ids[15]), (&[69, 85][..], 85));
    }
}
