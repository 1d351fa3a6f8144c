//! Where a mesh stands: scale, then rotate, then translate, in f64, rounded to f32 once.

/// A similarity of space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// Uniform scale; negative mirrors through the origin; not 0.
    pub scale: f64,
    /// Rotation matrix, by rows.
    pub rotation: [[f64; 3]; 3],
    /// Shift, scene units.
    pub translate: [f64; 3],
}

impl Default for Transform {
    fn default() -> Self {
        let rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Transform { scale: 1.0, rotation, translate: [0.0; 3] }
    }
}

impl Transform {
    /// The world position of an object point; infinite where it leaves the range of f32.
    pub fn apply(&self, p: [f32; 3]) -> [f32; 3] {
        if *self == Transform::default() {
            return p; // keeps even the sign of zeros
        }
        let p = p.map(|x| f64::from(x) * self.scale);
        std::array::from_fn(|i| {
            let r = self.rotation[i];
            (r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + self.translate[i]) as f32
        })
    }

    /// The unit world normal of a surface with this object normal; zero if that is zero or not finite.
    pub fn apply_to_normal(&self, n: [f32; 3]) -> [f32; 3] {
        // A similarity turns normals as it turns points, and mirrors them too.
        let n = n.map(|x| f64::from(x) * self.scale.signum());
        let n = glam::DVec3::from_array(std::array::from_fn(|i| {
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

/// The distance between two points.
pub fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    glam::DVec3::from(a).distance(glam::DVec3::from(b))
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
