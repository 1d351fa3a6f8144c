//! Colours that a file states in other primaries than Rec.709, made linear Rec.709.

type Matrix = [[f64; 3]; 3];

/// The CIE x and y of red, green, blue and white.
pub(super) type Chromaticities = [[f64; 2]; 4];

/// ITU-R BT.709, of which white is D65.
pub(super) const REC709: Chromaticities = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], [0.3127, 0.3290]];

/// Chromaticities that differ by less name the same colours: files round theirs to three or four digits.
const SAME: f64 = 2e-3;

/// From cone responses of Bradford's kind to those (Lam 1985, as ICC profiles use them).
const BRADFORD: Matrix = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

/// What makes colours of the primaries `of` linear Rec.709, white becoming white (von Kries, on Bradford's cones); `Ok(None)` if
/// they are Rec.709 already.
///
/// # Errors
/// The four span no colours.
pub(super) fn to_rec709(of: Chromaticities) -> Result<Option<Matrix>, String> {
    if of.iter().flatten().zip(REC709.iter().flatten()).all(|(a, b)| (a - b).abs() <= SAME) {
        return Ok(None);
    }
    let useless = || format!("the primaries {of:?} (red, green, blue, white) span no colours");
    let theirs = to_xyz(of).ok_or_else(useless)?;
    let ours = to_xyz(REC709).and_then(inverse).ok_or_else(useless)?;
    let white = |of: Chromaticities| apply(&BRADFORD, xyz(of[3]));
    let (from, to) = (white(of), white(REC709));
    let scale = |row: usize, column: usize| if row == column { to[row] / from[row] } else { 0.0 };
    let scale: Matrix = std::array::from_fn(|row| std::array::from_fn(|column| scale(row, column)));
    let cones = inverse(BRADFORD).ok_or_else(useless)?;
    let matrix = [cones, scale, BRADFORD, theirs].iter().fold(ours, |product, next| times(&product, next));
    matrix.iter().flatten().all(|x| x.abs() < 1e3).then_some(Some(matrix)).ok_or_else(useless)
}

/// From CIE XYZ, in which Rec.709 white has luminance 1.
pub(super) fn from_xyz() -> Matrix {
    to_xyz(REC709).and_then(inverse).unwrap_or([[0.0; 3]; 3])
}

/// `matrix` times each pixel.
pub(super) fn convert(matrix: &Matrix, pixels: &mut [[f32; 3]]) {
    for pixel in pixels {
        *pixel = apply(matrix, pixel.map(f64::from)).map(|value| value as f32);
    }
}

/// The colour of luminance 1 at x and y.
fn xyz([x, y]: [f64; 2]) -> [f64; 3] {
    [x / y, 1.0, (1.0 - x - y) / y]
}

/// To CIE XYZ (SMPTE RP 177): white has luminance 1. `None` if there is none.
fn to_xyz(of: Chromaticities) -> Option<Matrix> {
    // Columns as x, y, z: a primary may lie at y = 0.
    let [r, g, b] = [of[0], of[1], of[2]].map(|[x, y]| [x, y, 1.0 - x - y]);
    let primaries = [[r[0], g[0], b[0]], [r[1], g[1], b[1]], [r[2], g[2], b[2]]];
    let amounts = apply(&inverse(primaries)?, xyz(of[3]));
    let matrix = primaries.map(|row| std::array::from_fn(|column| row[column] * amounts[column]));
    matrix.iter().flatten().all(|x: &f64| x.is_finite()).then_some(matrix)
}

fn apply(matrix: &Matrix, v: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|row| std::array::from_fn(|column| (0..3).map(|i| a[row][i] * b[i][column]).sum()))
}

/// `None` if there is none.
fn inverse(m: Matrix) -> Option<Matrix> {
    let minor = |row: usize, column: usize| {
        let (a, b, c, d) = ((row + 1) % 3, (row + 2) % 3, (column + 1) % 3, (column + 2) % 3);
        m[a][c] * m[b][d] - m[a][d] * m[b][c]
    };
    let determinant: f64 = (0..3).map(|column| m[0][column] * minor(0, column)).sum();
    let matrix: Matrix = std::array::from_fn(|row| std::array::from_fn(|column| minor(column, row) / determinant));
    (determinant.abs() > 1e-9 && matrix.iter().flatten().all(|x| x.is_finite())).then_some(matrix)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn far(a: &Matrix, b: &Matrix) -> f64 {
        a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn rec709_has_the_published_matrix() {
        // IEC 61966-2-1, four digits.
        let published = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]];
        assert!(far(&to_xyz(REC709).unwrap(), &published) < 1e-4);
        assert_eq!(to_rec709(REC709), Ok(None));
    }

    #[test]
    fn aces_has_the_published_matrix() {
        // ACES 2065-1 (AP0, D60) to linear Rec.709, Bradford: the ACES project's own figures.
        let ap0 = [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], [0.32168, 0.33767]];
        let published = [[2.5217, -1.1341, -0.3876], [-0.2765, 1.3727, -0.0962], [-0.0154, -0.1530, 1.1684]];
        assert!(far(&to_rec709(ap0).unwrap().unwrap(), &published) < 5e-4, "{:?}", to_rec709(ap0));
    }

    #[test]
    fn what_spans_nothing_is_refused() {
        for of in [[[0.0; 2]; 4], [[0.3, 0.3]; 4], [[f64::NAN, 0.3], [0.3, 0.6], [0.15, 0.06], [0.31, 0.33]]] {
            assert!(to_rec709(of).is_err());
        }
    }
}
