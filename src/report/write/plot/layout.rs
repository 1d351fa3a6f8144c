//! How much room a plot has and what stands where.

/// How much room a plot has, in its own units; text is 13 of them high.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    pub(super) width: f64,
    pub(super) height: f64,
    /// Most room right of the drawing for names; 0: none stand there.
    pub(super) names: f64,
    /// Least room left of it.
    pub(super) left: f64,
    /// Size of the markers, 1 being usual.
    pub(super) markers: f64,
    /// Brings its own styles and ground, as a file by itself needs them.
    pub(super) alone: bool,
}

impl Layout {
    /// In a page on a desk.
    pub const WIDE: Layout =
        Layout { width: 960.0, height: 560.0, names: 300.0, left: 66.0, markers: 1.0, alone: false };
    /// In a page on a phone.
    pub const NARROW: Layout =
        Layout { width: 470.0, height: 430.0, names: 215.0, left: 58.0, markers: 1.0, alone: false };
    /// One of many that are compared: a heading above, no names at the lines ([`super::legend`] says them once for all).
    pub const SMALL: Layout =
        Layout { width: 300.0, height: 230.0, names: 0.0, left: 44.0, markers: 0.75, alone: false };
    /// A file by itself.
    pub const FILE: Layout = Layout { alone: true, ..Layout::WIDE };

    /// Whether names stand at the lines.
    pub(super) fn has_names(self) -> bool {
        self.names > 0.0
    }

    /// Right of the drawing where no names stand: half of the last label of the x axis.
    pub(super) const MARGIN: f64 = 16.0;
}
