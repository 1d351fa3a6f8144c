//! Which lanes move where when some are taken out.

use crate::lanes::LANES;

/// `COMPRESS[mask]`: the numbers of the lanes set in `mask`, ascending, then zeros.
pub(crate) static COMPRESS: [[u32; LANES]; 256] = {
    let mut table = [[0u32; LANES]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut place) = (0, 0);
        while lane < LANES {
            if mask >> lane & 1 == 1 {
                table[mask][place] = lane as u32;
                place += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
};
