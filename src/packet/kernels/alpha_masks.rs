//! Cut-outs for eight rays at a time: the alpha test, and rays that pass what is not there.

use super::here;
use crate::bvh::{Bvh, HitQueue, RayQueue, Scratch};
use crate::packet::queues::IndexList;
use crate::tables::alpha_masks::{AlphaMaskTable, THRESHOLD, WHOLE};
use here::kernels::columns::RowLanes;
use here::kernels::records::AlphaMaskColumns;
use here::kernels::texture::{interpolate, mix, neighbours};
use here::lanes::{Each, F32x8, LANES, Mask8, U32x8, inlined};

/// Lanes whose triangles are there at the points with weights (1-u-v, u, v): their masks, bilinear and repeated as
/// textures are, are at least one half. Ids beyond the table, as those of rays that hit nothing, are whole.
#[inline(always)]
pub fn opaque(table: &AlphaMaskTable, triangle: U32x8, u: F32x8, v: F32x8) -> Mask8 {
    let record_of = |id: u32| table.record_of.get(id as usize).copied().unwrap_or(WHOLE);
    let record = U32x8::from_array(triangle.to_array().map(record_of));
    let whole = record.eq(U32x8::splat(WHOLE));
    if whole.all() {
        return Mask8::ALL;
    }
    // Whole lanes look at the first texel of the first mask, wherever their coordinates lead.
    let record = AlphaMaskColumns::gather(&table.records, whole.select_u32(U32x8::ZERO, record));
    let uv = interpolate(record.uvs, [F32x8::ONE - u - v, u, v]);
    let uv = uv.each(
        #[inline(always)]
        |t| whole.select(F32x8::ZERO, t),
    );
    let column = |column: &[u32]| U32x8::gather(column, record.mask);
    let (width, height, first) = (column(&table.width), column(&table.height), column(&table.first));
    let (left, right, along) = neighbours(uv[0], width.to_f32());
    let (below, above, up) = neighbours(uv[1], height.to_f32());
    let texel = inlined(
        #[inline(always)]
        |column: U32x8, row: U32x8| {
            let at = (first + row * width + column).to_array();
            U32x8::from_array(at.map(|at| table.texels[at as usize].into())).to_f32()
        },
    );
    let low = mix(texel(left, below), texel(right, below), along);
    let high = mix(texel(left, above), texel(right, above), along);
    whole | mix(low, high, up).ge(F32x8::splat(THRESHOLD))
}

/// Whether what the ray of one row has hit is there; what hits nothing is.
#[inline(always)]
pub fn is_there(table: &AlphaMaskTable, hits: &HitQueue, row: usize) -> bool {
    let (u, v) = (F32x8::splat(hits.u[row]), F32x8::splat(hits.v[row]));
    opaque(table, U32x8::splat(hits.triangle[row]), u, v).all()
}

/// Moves the hits of rays `0 .. count` that are not there on to the first ones behind that are. `passing`: working memory.
#[inline(never)]
pub fn pass_alpha_masks(
    (bvh, table): (&Bvh, &AlphaMaskTable),
    (rays, count): (&RayQueue, usize),
    hits: &mut HitQueue,
    passing: &mut IndexList,
    scratch: &mut Scratch,
) {
    here::run(
        #[inline(always)]
        || {
            passing.len = 0;
            for first in (0..count).step_by(LANES) {
                let active = Mask8::first((count - first).min(LANES));
                let (u, v) = (F32x8::load(&hits.u, first), F32x8::load(&hits.v, first));
                let opaque = opaque(table, U32x8::load(&hits.triangle, first), u, v);
                passing.append(first, active.and_not(opaque).bits());
            }
            while passing.len > 0 {
                bvh.intersect_behind(rays, &passing.rows[..passing.len], hits, scratch);
                let count = std::mem::take(&mut passing.len);
                for first in (0..count).step_by(LANES) {
                    let active = Mask8::first((count - first).min(LANES));
                    let row = active.select_u32(U32x8::load(&passing.rows, first), U32x8::ZERO);
                    let (u, v) = (F32x8::gather(&hits.u, row), F32x8::gather(&hits.v, row));
                    let bits = active.and_not(opaque(table, U32x8::gather(&hits.triangle, row), u, v)).bits();
                    // What is kept never lies behind what has been read.
                    row.compress(bits).store(&mut passing.rows, passing.len);
                    passing.len += bits.count_ones() as usize;
                }
            }
        },
    )
}
