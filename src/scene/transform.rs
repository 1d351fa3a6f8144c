//! Where an instance of a mesh stands: computed in f64, rounded to f32 once.

use glam::DVec3;

/// From the object space of a mesh to world space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Transform {
    /// Object space is world space: not a bit of the mesh changes.
    #[default]
    Identity,
    /// Scale, then rotate, then translate.
    Similarity(Similarity),
    /// An affine map by its rows: `p'[i] = m[i][0] p[0] + m[i][1] p[1] + m[i][2] p[2] + m[i][3]`, the last column in
    /// scene units. Its columns 0 to 2 must be independent.
    Matrix([[f64; 4]; 3]),
}

impl Transform {
    /// The world position of an object point; infinite where it leaves the range of f32.
    pub fn apply(&self, p: [f32; 3]) -> [f32; 3] {
        match self {
            Transform::Identity => p,
            Transform::Similarity(similarity) => similarity.apply(p),
            Transform::Matrix(rows) => {
                let p = p.map(f64::from);
                rows.map(|m| (m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3]) as f32)
            }
        }
    }

    /// The world normal of a surface with this object normal: a unit vector, or zero if it is zero or not finite; unchanged
    /// by [`Transform::Identity`].
    pub fn apply_to_normal(&self, n: [f32; 3]) -> [f32; 3] {
        match self {
            Transform::Identity => n,
            Transform::Similarity(similarity) => similarity.apply_to_normal(n),
            Transform::Matrix(rows) => {
                // The inverse transpose is the matrix of cofactors over the determinant, of which only the sign matters.
                let [a, b, c] = columns(rows);
                let n = DVec3::from(n.map(f64::from));
                let n = (b.cross(c) * n.x + c.cross(a) * n.y + a.cross(b) * n.z) * a.dot(b.cross(c)).signum();
                n.try_normalize().map_or([0.0; 3], |n| n.as_vec3().to_array())
            }
        }
    }

    /// Whether it turns right hands into left hands: a winding that faced outwards then faces inwards.
    pub fn mirrors(&self) -> bool {
        match self {
            Transform::Identity => false,
            Transform::Similarity(similarity) => similarity.mirrors(),
            Transform::Matrix(rows) => {
                let [a, b, c] = columns(rows);
                a.dot(b.cross(c)) < 0.0
            }
        }
    }

    /// Why nothing can stand under this transform, if so.
    pub fn fault(&self) -> Option<&'static str> {
        match self {
            Transform::Identity => None,
            Transform::Similarity(Similarity { scale, rotation, translate }) => {
                if !(scale.is_finite() && *scale != 0.0 && translate.iter().all(|x| x.is_finite())) {
                    return Some("its scale is 0, or its scale or translation is not finite");
                }
                let axis = |i: usize| DVec3::from(rotation.map(|row| row[i]));
                (!independent([axis(0), axis(1), axis(2)])).then_some("its rotation matrix is singular or not finite")
            }
            Transform::Matrix(rows) => matrix_fault(rows),
        }
    }
}

/// Why `rows`, an affine map, cannot be inverted, if so.
pub fn matrix_fault(rows: &[[f64; 4]; 3]) -> Option<&'static str> {
    if !rows.iter().flatten().all(|&x| (x as f32).is_finite()) {
        return Some("its matrix must hold finite numbers below 3.4e38");
    }
    let fault = "its matrix is singular: the first three columns must be independent and longer than 1e-30";
    (!independent(columns(rows))).then_some(fault)
}

/// Columns 0 to 2.
fn columns(rows: &[[f64; 4]; 3]) -> [DVec3; 3] {
    std::array::from_fn(|i| DVec3::from(rows.map(|row| row[i])))
}

/// Whether three vectors span space, whatever their lengths down to 1e-30; products of shorter ones vanish in f64.
fn independent(axes: [DVec3; 3]) -> bool {
    let [a, b, c] = axes.map(DVec3::normalize_or_zero);
    axes.iter().all(|axis| axis.length() > 1e-30) && a.dot(b.cross(c)).abs() > 1e-12
}

/// Scale, then rotate, then translate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Similarity {
    /// Uniform scale; negative mirrors through the origin; not 0.
    pub scale: f64,
    /// Rotation matrix, by rows.
    pub rotation: [[f64; 3]; 3],
    /// Shift, scene units.
    pub translate: [f64; 3],
}

impl Default for Similarity {
    fn default() -> Self {
        let rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Similarity { scale: 1.0, rotation, translate: [0.0; 3] }
    }
}

impl Similarity {
    /// The world position of an object point; infinite where it leaves the range of f32.
    pub fn apply(&self, p: [f32; 3]) -> [f32; 3] {
        self.place(p.map(f64::from))
    }

    /// The world position of an object point that was read in f64: placed in f64, rounded once.
    pub fn place(&self, p: [f64; 3]) -> [f32; 3] {
        if *self == Similarity::default() {
            return p.map(|x| x as f32); // keeps even the sign of zeros
        }
        let p = p.map(|x| x * self.scale);
        std::array::from_fn(|i| {
            let r = self.rotation[i];
            (r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + self.translate[i]) as f32
        })
    }

    /// The unit world normal of a surface with this object normal; zero if that is zero or not finite.
    pub fn apply_to_normal(&self, n: [f32; 3]) -> [f32; 3] {
        // A similarity turns normals as it turns points, and mirrors them too.
        let n = n.map(|x| f64::from(x) * self.scale.signum());
        let n = DVec3::from_array(std::array::from_fn(|i| {
            let r = self.rotation[i];
            r[0] * n[0] + r[1] * n[1] + r[2] * n[2]
        }));
        n.try_normalize().map_or([0.0; 3], |n| n.as_vec3().to_array())
    }

    /// Whether it turns right hands into left hands: a winding that faced outwards then faces inwards.
    pub fn mirrors(&self) -> bool {
        self.scale < 0.0
    }
}

/// 1 - cos of an angle in degrees, without the loss of digits that the difference has for small ones.
pub fn versine(degrees: f64) -> f64 {
    let half = (0.5 * degrees).to_radians().sin();
    2.0 * half * half
}

/// The distance between two points.
pub fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    DVec3::from(a).distance(DVec3::from(b))
}

/// The matrix that turns by `degrees` about `axis` (any length but 0), counter-clockwise seen from the axis' tip: the
/// formula of Rodrigues. Quarter turns are exact.
pub fn rotation(axis: [f64; 3], degrees: f64) -> [[f64; 3]; 3] {
    // Two steps of scaling: the square of a long or short axis may overflow or vanish.
    let largest = axis.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let axis = axis.map(|x| x / largest);
    let length = (axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]).sqrt();
    let [x, y, z] = axis.map(|x| x / length);
    let (s, c) = sin_cos_degrees(degrees);
    let t = 1.0 - c;
    [
        [t * x * x + c, t * x * y - s * z, t * x * z + s * y],
        [t * x * y + s * z, t * y * y + c, t * y * z - s * x],
        [t * x * z - s * y, t * y * z + s * x, t * z * z + c],
    ]
}

/// (sine, cosine) of an angle in degrees: exact at quarter turns, through `libm` (the same bits everywhere) elsewhere.
fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    let turned = degrees % 360.0;
    match if turned < 0.0 { turned + 360.0 } else { turned } {
        0.0 | 360.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        other => libm::sincos(other.to_radians()),
    }
}
