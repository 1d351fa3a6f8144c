//! Faults that tests plant, so that every row of `octray check` is known to fail when what it watches over is broken.
//!
//! **Law:** outside this library's own unit tests [`planted`] is the constant `false` and a hook costs nothing. In them it asks
//! the thread it runs on, so that tests in other threads see no fault: whoever plants one renders on one thread.

/// A fault that a hook in the code can commit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Multiple importance sampling takes each technique's density for the other's.
    SwappedPdf,
    /// The balance and power heuristics take the other technique's density twice.
    DensityTwice,
    /// Scalars alone: densities that are no numbers weigh 0, all others a little too much.
    WeightOfNoNumber,
    /// Pixels add their samples in f32.
    F32Sum,
    /// Samples that are not finite are added to pixels.
    TakenThoughNotFinite,
    /// A render that goes on from a picture forgets what that holds.
    LostPass,
    /// Several threads leave a trace in the picture.
    TraceOfThreads,
    /// Image files hold other values than the film.
    RoundedFile,
    /// Camera rays go through the film one and a half pixels beside.
    ShiftedFilm,
    /// Scalars in f32 alone: rays through a lens are longer than 1.
    DirectionNotUnit,
    /// A lens is in focus elsewhere.
    WrongFocus,
    /// Of a matrix that places a camera one axis is normalised, the others not.
    ScaledAxes,
    /// Loading warns of nothing.
    SilentLimits,
    /// The scalar triangle test shears rays wrongly.
    WrongShear,
    /// The scalar triangle test leaves out its edges.
    ClosedEdges,
    /// Single rays that hit nothing are said to have hit triangle 0.
    MissesHit,
    /// The axes of a frame are not perpendicular.
    SkewedFrame,
    /// Cosine-weighted directions are too long.
    LongDirection,
    /// Microfacets hide too little of each other.
    LostMasking,
    /// Dielectrics reflect too much, and absorb none of it.
    BrightCoat,
    /// Samples of metals and coats state a density that is not theirs.
    StaleDensity,
    /// Fresnel reflectances are no numbers at grazing angles.
    NoNumberAtGrazing,
    /// Glass refracts by another index than it says.
    WrongRefraction,
    /// The bases of plastics reflect too much for their coats.
    BrightBase,
    /// Diffuse surfaces reflect more than their albedo.
    BrightAlbedo,
    /// Rows of an environment map are taken for taller than they are.
    TallRows,
    /// Directions are looked up in the wrong column and row of an environment map.
    ShiftedLookup,
    /// Pictures state a quarter of their error.
    SmallErrors,
    /// In f32 alone the kernels of the reference are off by a thousandth.
    LostDigits,
    /// In f32 alone the scalar triangle test leaves out a twentieth along each edge.
    SmallTriangles,
    /// A black environment map is taken for a light.
    BlackMapTaken,
    /// Packets alone: light samples on diffuse surfaces lack their cosine.
    MissingCosine,
    /// Scalars in f32 alone: the density of diffuse directions is 1 % too high.
    ScalarDensity,
    /// Packets alone: survivors of Russian roulette gain 1 % too little.
    BiasedRoulette,
    /// Packets alone: shadow rays that roulette lets be traced do not stand for those that it ends.
    ForgottenShadowRays,
    /// Surfaces reflect a hundredth less than they say.
    LossySurfaces,
    /// Rays start 1e-4 units off every surface.
    AbsoluteEpsilon,
    /// Copies of triangles are kept.
    KeptCopies,
    /// The probabilities of light selections that do not depend on the place are stated a tenth too low.
    LopsidedChoice,
    /// Lamps sampled and met have infinite radiance.
    InfiniteRadiance,
    /// All lamps shine on both sides.
    BothSidesShine,
    /// Scenes too large, too small or too far off for f32 are taken without a word.
    NoScaleLimits,
    /// Rays start on the other side of the triangle they leave.
    WrongOffset,
    /// Every seventh triangle is missing in the tree.
    LostTriangle,
    /// The camera's eye lies a thousandth farther from the origin.
    EyeElsewhere,
    /// The walk of single rays finds nothing.
    BlindWalk,
    /// Plans that put smooth normals back have them where there are none.
    BentCorners,
}

/// What code that is compiled for f32 and f64 multiplies a value with, `epsilon` being its own: 1, unless
/// [`Fault::LostDigits`] is planted.
#[inline(always)]
pub fn lost_digits(epsilon: f64) -> f64 {
    if planted(Fault::LostDigits) && epsilon > 1e-10 { 1.001 } else { 1.0 }
}

/// Whether `fault` is to be committed here.
#[cfg(not(test))]
#[inline(always)]
pub const fn planted(_: Fault) -> bool {
    false
}

/// Whether `fault` is to be committed here.
#[cfg(test)]
pub fn planted(fault: Fault) -> bool {
    tests::PLANTED.get() == Some(fault)
}

#[cfg(test)]
pub mod tests {
    use super::Fault;
    use std::cell::Cell;

    thread_local! {
        /// The fault of this thread.
        pub static PLANTED: Cell<Option<Fault>> = const { Cell::new(None) };
    }

    /// What `work` comes to with `fault` planted.
    pub fn with<T>(fault: Fault, work: impl FnOnce() -> T) -> T {
        PLANTED.set(Some(fault));
        let result = work();
        PLANTED.set(None);
        result
    }
}
