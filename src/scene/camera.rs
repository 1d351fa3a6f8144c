//! What a scene says of its camera, and of how it moves: keys in time, and what lies between them.

/// A camera that looks at a point, or that a matrix places. Lengths in scene units, angle in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraDesc {
    /// The eye.
    pub position: [f64; 3],
    /// A point on the optical axis; not the eye.
    pub look_at: [f64; 3],
    /// Up; not parallel to the axis.
    pub up: [f64; 3],
    /// Camera space to world space, by rows, in place of `position`, `look_at` and `up`: `p'[i] = m[i][0] x + m[i][1] y +
    /// m[i][2] z + m[i][3]`. Its columns are right, up, backward and the eye: the camera looks along its own -z, with x to the
    /// image's right and y to its top. The axes need not be orthonormal but must be independent; the lens and the plane in
    /// focus are measured in camera space.
    pub to_world: Option<[[f64; 4]; 3]>,
    /// Full vertical field of view, in (0, 180) degrees.
    pub vertical_fov: f64,
    /// Radius of the thin lens, scene units; 0: a pinhole.
    pub aperture_radius: f64,
    /// Distance of the plane in focus from the eye, along the axis, scene units; above 0. Of no effect on a pinhole.
    pub focus_distance: f64,
}

impl CameraDesc {
    /// The eye, whichever way the camera is placed.
    pub fn eye(&self) -> [f64; 3] {
        self.to_world.map_or(self.position, |rows| rows.map(|row| row[3]))
    }
}

impl CameraDesc {
    /// How far from the origin of the scene, along any axis, the eye and its lens reach.
    pub fn reach(&self) -> f64 {
        let lens = self.to_world.map_or(1.0, |rows| {
            let length = |i: usize| rows.iter().map(|row| row[i] * row[i]).sum::<f64>().sqrt();
            length(0).max(length(1))
        });
        self.eye().iter().fold(0.0, |most: f64, x| most.max(x.abs())) + self.aperture_radius * lens
    }
}

impl Default for CameraDesc {
    fn default() -> Self {
        CameraDesc {
            position: [0.0, 0.0, 1.0],
            look_at: [0.0; 3],
            up: [0.0, 1.0, 0.0],
            to_world: None,
            vertical_fov: 35.0,
            aperture_radius: 0.0,
            focus_distance: 1.0,
        }
    }
}

/// The camera at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraKey {
    /// Seconds; finite.
    pub time: f64,
    /// The camera.
    pub camera: CameraDesc,
}

/// Keys of a camera that moves; none: it stands still.
///
/// Eye and point looked at run along a cubic through the keys whose tangents are those of parabolas through three keys (the
/// first and last three at the ends), so that motion has no corners; everything else changes evenly from key to key, so that it
/// never leaves what the keys say. Before the first key and after the last the camera stands still. All of it is made of
/// exactly rounded operations in f64: a frame has the same bits everywhere.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CameraPath(Vec<CameraKey>);

impl CameraPath {
    /// The path through `keys`, in any order.
    ///
    /// # Errors
    /// The time that two keys share, or that is not finite.
    pub fn new(mut keys: Vec<CameraKey>) -> Result<CameraPath, f64> {
        keys.sort_by(|a, b| a.time.total_cmp(&b.time));
        let unfit = keys.iter().find(|key| !key.time.is_finite());
        let twice = keys.windows(2).find(|pair| pair[0].time == pair[1].time).map(|pair| &pair[0]);
        match unfit.or(twice) {
            Some(key) => Err(key.time),
            None => Ok(CameraPath(keys)),
        }
    }

    /// The keys, by time.
    pub fn keys(&self) -> &[CameraKey] {
        &self.0
    }

    /// The camera at `time`; `None` where it has no keys.
    pub fn at(&self, time: f64) -> Option<CameraDesc> {
        let keys = &self.0;
        let right = keys.iter().position(|key| key.time > time).unwrap_or(keys.len());
        match (right.checked_sub(1), keys.get(right)) {
            (Some(left), Some(next)) => {
                let part = (time - keys[left].time) / (next.time - keys[left].time);
                Some(self.between(left, part))
            }
            (Some(last), None) => Some(keys[last].camera),
            (None, first) => Some(first?.camera),
        }
    }

    /// The camera of a frame, `fps` of them a second; `None` where it has no keys.
    pub fn at_frame(&self, frame: i64, fps: f64) -> Option<CameraDesc> {
        self.at(frame as f64 / fps)
    }

    /// The camera between key `left` and the next, at a share in [0, 1) of the way.
    fn between(&self, left: usize, part: f64) -> CameraDesc {
        let [a, b] = [self.0[left].camera, self.0[left + 1].camera];
        let even = |a: f64, b: f64| a + (b - a) * part;
        let evenly = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|i| even(a[i], b[i]));
        let along =
            |of: fn(&CameraDesc) -> [f64; 3]| std::array::from_fn(|axis| self.cubic(left, part, |c| of(c)[axis]));
        let rows = a.to_world.zip(b.to_world);
        CameraDesc {
            position: along(|camera| camera.position),
            look_at: along(|camera| camera.look_at),
            up: evenly(a.up, b.up),
            // One that a matrix places and one that looks at a point have nothing between them.
            to_world: rows
                .map(|(a, b)| std::array::from_fn(|i| std::array::from_fn(|j| even(a[i][j], b[i][j]))))
                .or(a.to_world),
            vertical_fov: even(a.vertical_fov, b.vertical_fov),
            aperture_radius: even(a.aperture_radius, b.aperture_radius),
            focus_distance: even(a.focus_distance, b.focus_distance),
        }
    }

    /// A cubic from key `left` to the next with given tangents (Hermite).
    fn cubic(&self, left: usize, part: f64, value: impl Fn(&CameraDesc) -> f64 + Copy) -> f64 {
        let (a, b) = (value(&self.0[left].camera), value(&self.0[left + 1].camera));
        let width = self.0[left + 1].time - self.0[left].time;
        let (from, to) = (self.tangent(left, value) * width, self.tangent(left + 1, value) * width);
        let rest = 1.0 - part;
        // The chord, and what the tangents bend it by at either end.
        a + (b - a) * part + part * rest * ((from - (b - a)) * rest - (to - (b - a)) * part)
    }

    /// The slope at a key of the parabola through it and its neighbours; of two keys that of the line.
    fn tangent(&self, key: usize, value: impl Fn(&CameraDesc) -> f64) -> f64 {
        let slope = |i: usize| {
            let (a, b) = (&self.0[i], &self.0[i + 1]);
            (value(&b.camera) - value(&a.camera)) / (b.time - a.time)
        };
        let last = self.0.len() - 1;
        if last == 1 {
            return slope(0);
        }
        let middle = key.clamp(1, last - 1);
        let (before, after) = (slope(middle - 1), slope(middle));
        let [a, b, c] = [middle - 1, middle, middle + 1].map(|i| self.0[i].time);
        before + (after - before) * ((2.0 * self.0[key].time - a - b) / (c - a))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(time: f64, x: f64) -> CameraKey {
        let camera = CameraDesc { position: [x, 1.0, 4.0], vertical_fov: 30.0 + x, ..CameraDesc::default() };
        CameraKey { time, camera }
    }

    fn path(keys: &[(f64, f64)]) -> CameraPath {
        CameraPath::new(keys.iter().map(|(time, x)| key(*time, *x)).collect()).unwrap()
    }

    #[test]
    fn the_path_runs_through_its_keys_and_stands_still_outside() {
        let keys = [(2.0, 5.0), (0.0, 1.0), (3.0, -1.0)];
        let path = path(&keys);
        for (time, x) in keys {
            assert_eq!(path.at(time).unwrap(), key(time, x).camera);
        }
        assert_eq!((path.at(-9.0), path.at(99.0)), (path.at(0.0), path.at(3.0)));
        assert_eq!(CameraPath::default().at(0.0), None);
    }

    #[test]
    fn parabolas_are_followed_exactly_and_lines_by_two_keys() {
        // x = t^2: any three keys tell it, at uneven times as well.
        let path_of = |times: &[f64]| path(&times.iter().map(|t| (*t, t * t)).collect::<Vec<_>>());
        for times in [&[0.0, 1.0, 4.0][..], &[0.0, 0.5, 1.0, 4.0]] {
            for time in [0.25, 0.75, 2.0, 3.5] {
                let found = path_of(times).at(time).unwrap();
                assert!((found.position[0] - time * time).abs() < 1e-12, "{times:?} {time}: {found:?}");
                assert_eq!(found.position[1..], [1.0, 4.0]);
            }
        }
        let line = path(&[(0.0, 0.0), (2.0, 8.0)]);
        assert_eq!(line.at(0.5).unwrap().position[0], 2.0);
        // What is no place changes evenly.
        assert_eq!(path_of(&[0.0, 2.0, 4.0]).at(1.0).unwrap().vertical_fov, 32.0);
    }

    #[test]
    fn motion_has_no_corners() {
        let path = path(&[(0.0, 0.0), (1.0, 3.0), (1.5, -2.0), (4.0, 1.0)]);
        for time in [1.0, 1.5] {
            let x = |time: f64| path.at(time).unwrap().position[0];
            let (before, after) = ((x(time) - x(time - 1e-6)) / 1e-6, (x(time + 1e-6) - x(time)) / 1e-6);
            assert!((before - after).abs() < 1e-3, "{time}: {before} {after}");
        }
    }

    #[test]
    fn two_keys_of_one_time_are_refused() {
        assert_eq!(CameraPath::new(vec![key(1.0, 0.0), key(0.0, 0.0), key(1.0, 2.0)]), Err(1.0));
        assert!(CameraPath::new(vec![key(f64::NAN, 0.0)]).is_err());
    }
}
