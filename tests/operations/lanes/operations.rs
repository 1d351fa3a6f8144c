//! Every lane operation against the same operation on plain `f32` and `u32`, over all pairs of awkward values.

use super::lanes::{F32x8, LANES, Mask8, U32x8, Vec3x8, count_at_most, sin_cos_turns};
use octray::internal::math;

/// Signed zeros, ones, denormals, extremes, infinities, NaN and some ordinary numbers.
fn awkward() -> Vec<f32> {
    let mut values = vec![
        0.0,
        1.0,
        0.5,
        1.5,
        3.0,
        0.1,
        16_777_216.0,
        f32::MIN_POSITIVE,
        f32::from_bits(1),
        f32::from_bits(0x007f_ffff),
        f32::EPSILON,
        f32::MAX,
        f32::INFINITY,
        1e-20,
        1e20,
        std::f32::consts::PI,
        0.333_333_34,
    ];
    values.extend(values.clone().iter().map(|v| -v));
    values.push(f32::NAN);
    let mut state = 1u32;
    for _ in 0..200 {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        values.push(f32::from_bits(state));
    }
    values
}

/// Equal bits, or both NaN (whose payload no operation promises).
fn same(a: f32, b: f32) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

/// All pairs, eight at a time, in every lane.
fn pairs() -> Vec<([f32; LANES], [f32; LANES])> {
    let values = awkward();
    let n = values.len();
    let pair = |i: usize| (values[i / n % n], values[i % n]);
    (0..n * n)
        .map(|first| {
            let lanes: [(f32, f32); LANES] = std::array::from_fn(|lane| pair((first + lane) % (n * n)));
            (lanes.map(|p| p.0), lanes.map(|p| p.1))
        })
        .collect()
}

fn check_binary(name: &str, lanes: impl Fn(F32x8, F32x8) -> F32x8, scalar: impl Fn(f32, f32) -> f32) {
    for (a, b) in pairs() {
        let got = lanes(F32x8::from_array(a), F32x8::from_array(b)).to_array();
        for lane in 0..LANES {
            let wanted = scalar(a[lane], b[lane]);
            assert!(same(got[lane], wanted), "{name}({:e}, {:e}) = {:e}, not {wanted:e}", a[lane], b[lane], got[lane]);
        }
    }
}

fn check_compare(name: &str, lanes: impl Fn(F32x8, F32x8) -> Mask8, scalar: impl Fn(&f32, &f32) -> bool) {
    for (a, b) in pairs() {
        let got = lanes(F32x8::from_array(a), F32x8::from_array(b)).bits();
        for lane in 0..LANES {
            assert_eq!(got >> lane & 1 == 1, scalar(&a[lane], &b[lane]), "{name}({:e}, {:e})", a[lane], b[lane]);
        }
    }
}

#[test]
fn arithmetic_rounds_as_scalars_do() {
    check_binary("add", |a, b| a + b, |a, b| a + b);
    check_binary("sub", |a, b| a - b, |a, b| a - b);
    check_binary("mul", |a, b| a * b, |a, b| a * b);
    check_binary("div", |a, b| a / b, |a, b| a / b);
    check_binary("sqrt", |a, _| a.sqrt(), |a, _| a.sqrt());
    check_binary("neg", |a, _| -a, |a, _| -a);
    check_binary("abs", |a, _| a.abs(), |a, _| a.abs());
    check_binary("copysign", |a, b| a.copysign(b), |a, b| a.copysign(b));
}

#[test]
fn min_and_max_are_the_one_definition_to_the_bit() {
    for (a, b) in pairs() {
        let (va, vb) = (F32x8::from_array(a), F32x8::from_array(b));
        let (low, high) = (va.min(vb).to_array(), va.max(vb).to_array());
        for lane in 0..LANES {
            // Even a NaN's payload comes from one of the arguments, so bits must agree.
            assert_eq!(low[lane].to_bits(), math::min(a[lane], b[lane]).to_bits(), "min({:e}, {:e})", a[lane], b[lane]);
            assert_eq!(
                high[lane].to_bits(),
                math::max(a[lane], b[lane]).to_bits(),
                "max({:e}, {:e})",
                a[lane],
                b[lane]
            );
        }
    }
}

#[test]
fn comparisons_are_false_for_nan() {
    check_compare("lt", |a, b| a.lt(b), |a, b| a < b);
    check_compare("le", |a, b| a.le(b), |a, b| a <= b);
    check_compare("gt", |a, b| a.gt(b), |a, b| a > b);
    check_compare("ge", |a, b| a.ge(b), |a, b| a >= b);
    check_compare("eq", |a, b| a.eq(b), |a, b| a == b);
}

#[test]
fn integers_wrap_as_scalars_do() {
    for (a, b) in pairs() {
        let (a, b) = (a.map(f32::to_bits), b.map(f32::to_bits));
        let (va, vb) = (U32x8::from_array(a), U32x8::from_array(b));
        let check = |name: &str, got: U32x8, wanted: &dyn Fn(u32, u32) -> u32| {
            for lane in 0..LANES {
                assert_eq!(got.to_array()[lane], wanted(a[lane], b[lane]), "{name}({}, {})", a[lane], b[lane]);
            }
        };
        check("add", va + vb, &|a, b| a.wrapping_add(b));
        check("sub", va - vb, &|a, b| a.wrapping_sub(b));
        check("mul", va * vb, &|a, b| a.wrapping_mul(b));
        check("high", va.multiply_high(vb), &|a, b| ((a as u64 * b as u64) >> 32) as u32);
        check("and", va & vb, &|a, b| a & b);
        check("or", va | vb, &|a, b| a | b);
        check("xor", va ^ vb, &|a, b| a ^ b);
        check("shl", va << 7, &|a, _| a << 7);
        check("shr", va >> 16, &|a, _| a >> 16);
        check("reverse", va.reverse_bits(), &|a, _| a.reverse_bits());
        check("shr each", va.shift_right_each(vb & U32x8::splat(31)), &|a, b| a >> (b & 31));
        let table = std::array::from_fn(|i| (i as u8).wrapping_mul(37) ^ 5);
        let nibbles = U32x8::splat(0x0f0f_0f0f);
        check("bytes", (va & nibbles).look_up_bytes(table), &|a, _| {
            u32::from_le_bytes(a.to_le_bytes().map(|byte| table[usize::from(byte & 15)]))
        });
        check("min", va.min_signed(vb), &|a, b| (a as i32).min(b as i32) as u32);
        check("max", va.max_signed(vb), &|a, b| (a as i32).max(b as i32) as u32);
        check("lt", va.lt(vb).select_u32(U32x8::splat(1), U32x8::ZERO), &|a, b| (a < b) as u32);
        check("eq", va.eq(vb).select_u32(U32x8::splat(1), U32x8::ZERO), &|a, b| (a == b) as u32);
    }
}

#[test]
fn short_lists_are_counted_as_unsigned_numbers() {
    let mut state = 1u32;
    for round in 0..2_000u32 {
        let values: [u16; 16] = std::array::from_fn(|_| {
            state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            (state >> (16 + round % 16)) as u16
        });
        for most in [0, 1, values[3], values[9].wrapping_sub(1), 0x7fff, 0x8000, u16::MAX] {
            let wanted = values.iter().filter(|&&value| value <= most).count() as u32;
            assert_eq!(count_at_most(&values, most), wanted, "{values:?} {most}");
        }
    }
}

#[test]
fn conversions_are_exact_where_they_promise_to_be() {
    for base in [0u32, 1, 100, 8_388_600, 16_777_208] {
        let integers: [u32; LANES] = std::array::from_fn(|lane| base + lane as u32);
        let floats = U32x8::from_array(integers).to_f32();
        assert_eq!(floats.to_array(), integers.map(|i| i as f32));
        assert_eq!(
            U32x8::from_f32(floats + F32x8::splat(0.25)).to_array(),
            (floats.to_array()).map(|f| (f + 0.25) as u32)
        );
    }
}

#[test]
fn masks_compress_and_select_for_all_256_patterns() {
    let values: [f32; LANES] = std::array::from_fn(|lane| lane as f32 + 10.0);
    let poison = F32x8::splat(f32::NAN);
    for bits in 0..=255u8 {
        let mask = Mask8::from_bits(bits);
        assert_eq!(mask.bits(), bits);
        assert_eq!((!mask).bits(), !bits);
        assert_eq!((mask.count(), mask.any(), mask.all()), (bits.count_ones(), bits != 0, bits == 255));
        let wanted: Vec<f32> = (0..LANES).filter(|lane| bits >> lane & 1 == 1).map(|lane| values[lane]).collect();
        assert_eq!(F32x8::from_array(values).compress(bits).to_array()[..wanted.len()], wanted);
        let selected = mask.select(F32x8::from_array(values), poison).to_array();
        for (lane, value) in selected.into_iter().enumerate() {
            assert_eq!(value.is_nan(), bits >> lane & 1 == 0);
        }
    }
    for count in 0..=LANES {
        assert_eq!(Mask8::first(count).bits(), ((1u32 << count) - 1) as u8);
    }
}

#[test]
fn transpose_and_gather_move_every_element_where_it_belongs() {
    let rows: [F32x8; LANES] =
        std::array::from_fn(|row| F32x8::from_array(std::array::from_fn(|column| (8 * row + column) as f32)));
    let columns = F32x8::transpose(rows);
    for (c, column) in columns.iter().enumerate() {
        assert_eq!(column.to_array(), std::array::from_fn(|row| (8 * row + c) as f32));
    }
    let table: Vec<f32> = (0..100).map(|i| i as f32 * 0.5).collect();
    let indices = [99, 0, 3, 3, 50, 7, 98, 1];
    let gathered = F32x8::gather(&table, U32x8::from_array(indices)).to_array();
    assert_eq!(gathered, indices.map(|i| i as f32 * 0.5));
}

#[test]
fn vectors_follow_the_order_of_glam() {
    let values = awkward();
    for (i, &x) in values.iter().enumerate() {
        let (a, b) = (
            [x, values[(i * 7 + 1) % values.len()], values[(i * 3 + 2) % values.len()]],
            [values[(i * 5 + 3) % values.len()], values[(i + 11) % values.len()], values[(i * 2 + 5) % values.len()]],
        );
        let (ga, gb) = (glam::Vec3::from(a), glam::Vec3::from(b));
        let (va, vb) = (Vec3x8::splat(a), Vec3x8::splat(b));
        assert!(same(va.dot(vb).to_array()[3], ga.dot(gb)), "{a:?} . {b:?}");
        let cross = va.cross(vb);
        for (lane, scalar) in [cross.x, cross.y, cross.z].into_iter().zip(ga.cross(gb).to_array()) {
            assert!(same(lane.to_array()[5], scalar), "{a:?} x {b:?}");
        }
    }
}

#[test]
fn sine_and_cosine_have_the_bits_of_the_scalar_polynomial() {
    for first in (0..=1_000_000u32).step_by(LANES) {
        let turns: [f32; LANES] = std::array::from_fn(|lane| ((first + lane as u32) as f32 / 1e6).min(1.0));
        let (s, c) = sin_cos_turns(F32x8::from_array(turns));
        for (lane, &turns) in turns.iter().enumerate() {
            let (sine, cosine) = math::sin_cos_turns(turns);
            assert!(s.to_array()[lane].to_bits() == sine.to_bits(), "sin({turns})");
            assert!(c.to_array()[lane].to_bits() == cosine.to_bits(), "cos({turns})");
        }
    }
}
