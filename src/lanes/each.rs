//! Arrays of lanes element by element, closures that are inlined: what code that is compiled once a SIMD level uses in place of
//! `map` and `from_fn` of arrays.
//!
//! Those are functions of their own, compiled for the build's instructions. As soon as they are not inlined, which depends on
//! how much a closure does, every operation in them is a call that passes its lanes through memory.

/// An array.
pub trait Each<T> {
    /// One of as many `R`.
    type Of<R>;
    /// `f` of every element.
    fn each<R>(self, f: impl FnMut(T) -> R) -> Self::Of<R>;
}

macro_rules! arrays_of {
    ($($length:literal: $($element:ident)+;)+) => {
        $(impl<T> Each<T> for [T; $length] {
            type Of<R> = [R; $length];
            #[inline(always)]
            fn each<R>(self, mut f: impl FnMut(T) -> R) -> [R; $length] {
                let [$($element),+] = self;
                [$(f($element)),+]
            }
        })+
    };
}
arrays_of! {
    1: a;
    2: a b;
    3: a b c;
    4: a b c d;
    6: a b c d e f_;
    8: a b c d e f_ g h;
}

/// `f` itself. A closure that is an argument may be marked `#[inline(always)]`, one that is given a name may not.
#[inline(always)]
pub fn inlined<F>(f: F) -> F {
    f
}
