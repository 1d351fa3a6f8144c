//! The filters of FLIP (sections 4.1.1 and 4.2 of the paper of 2020): what the eye resolves, and edges and points.
//!
//! All are sums of products of one-dimensional filters (Gaussians and their derivatives), so rows are filtered first
//! and columns of the outcome next; a window of filtered rows moves down the image. Beyond the borders the last pixel
//! repeats. A filter is as wide as three standard deviations of the widest Gaussian, rounded up.

use super::color;
use crate::image::Image;
use glam::DVec3;
use std::collections::VecDeque;
use std::f64::consts::PI;

/// Gaussians of the contrast sensitivity functions, one for each of (achromatic, red-green) and two for blue-yellow:
/// weight a and scale b of a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees.
const SENSITIVITY: [(f64, f64); 4] = [(1.0, 0.004_7), (1.0, 0.005_3), (34.1, 0.04), (13.5, 0.025)];

/// The width of an edge that the detector looks for, in degrees: twice its standard deviation.
const EDGE_WIDTH: f64 = 0.082;

/// The exponent that raises small differences of features, q_f.
const FEATURE_EXPONENT: f64 = 0.5;

/// One-dimensional filters for one number of pixels per degree.
pub struct Filters {
    /// Achromatic, red-green, and two whose sum is blue-yellow.
    eye: [Vec<f64>; 4],
    /// A Gaussian, its first and its second derivative.
    feature: [Vec<f64>; 3],
}

impl Filters {
    /// The filters at `pixels_per_degree`, which is above 0.
    pub fn new(pixels_per_degree: f64) -> Filters {
        let widest = SENSITIVITY.iter().fold(0.0f64, |widest, (_, b)| widest.max(*b));
        let radius = (3.0 * (widest / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
        // In two dimensions the weight is a sqrt(pi / b) once: each dimension has its root.
        let eye = SENSITIVITY.map(|(a, b)| {
            let weight = |x: f64| (a * (PI / b).sqrt()).sqrt() * libm::exp(-PI * PI * x * x / b);
            (-radius..=radius).map(|i| weight(i as f64 / pixels_per_degree)).collect()
        });
        let deviation = 0.5 * EDGE_WIDTH * pixels_per_degree;
        let radius = (3.0 * deviation).ceil() as i32;
        let gaussian = |x: f64| libm::exp(-x * x / (2.0 * deviation * deviation));
        let forms: [&dyn Fn(f64) -> f64; 3] =
            [&gaussian, &|x| -x * gaussian(x), &|x| (x * x / (deviation * deviation) - 1.0) * gaussian(x)];
        let feature = forms.map(|form| (-radius..=radius).map(|i| form(i as f64)).collect());
        Filters { eye: normalised_together(eye), feature: feature.map(normalised_by_sign) }
    }

    fn radius(&self) -> usize {
        self.eye[0].len().max(self.feature[0].len()) / 2
    }
}

/// Filters whose squares, the two-dimensional filters, have the sum 1; blue-yellow is the sum of two.
fn normalised_together(eye: [Vec<f64>; 4]) -> [Vec<f64>; 4] {
    let sums = eye.each_ref().map(|filter| filter.iter().sum::<f64>());
    let blue_yellow = sums[2].hypot(sums[3]);
    let scales = [sums[0], sums[1], blue_yellow, blue_yellow];
    let mut eye = eye;
    for (filter, scale) in eye.iter_mut().zip(scales) {
        filter.iter_mut().for_each(|weight| *weight /= scale);
    }
    eye
}

/// The filter with positive weights of sum 1, and negative ones of sum -1.
fn normalised_by_sign(filter: Vec<f64>) -> Vec<f64> {
    let sum_of = |positive: bool| filter.iter().filter(|w| (**w > 0.0) == positive).sum::<f64>().abs();
    let (positive, negative) = (sum_of(true), sum_of(false));
    filter
        .iter()
        .map(|w| {
            if *w > 0.0 {
                w / positive
            } else if *w < 0.0 {
                w / negative
            } else {
                0.0
            }
        })
        .collect()
}

/// A row of pixels after all filters.
pub struct Row {
    /// Colours as perceived.
    pub colors: Vec<DVec3>,
    /// Strengths of edge and of point.
    pub features: Vec<[f64; 2]>,
}

/// A row filtered along x by each of [`Filters`]; all three of the feature detector see the achromatic channel.
struct AlongX {
    eye: [Vec<f64>; 4],
    feature: [Vec<f64>; 3],
}

/// The rows of an image around the current one, filtered along x.
pub struct Window<'a, S> {
    image: &'a Image,
    show: S,
    filters: &'a Filters,
    rows: VecDeque<AlongX>,
    /// Which row of the image is first in `rows`.
    first: usize,
}

impl<'a, S: Fn(DVec3) -> DVec3> Window<'a, S> {
    /// A window above the top of `image`; `show` makes displayed linear Rec.709 in [0, 1] of radiance.
    pub fn new(image: &'a Image, show: S, filters: &'a Filters) -> Window<'a, S> {
        Window { image, show, filters, rows: VecDeque::new(), first: 0 }
    }

    /// Row `y` after all filters; rows are asked for in order.
    pub fn row(&mut self, y: usize) -> Row {
        let radius = self.filters.radius();
        while self.first + radius < y {
            self.rows.pop_front();
            self.first += 1;
        }
        let last = (y + radius).min(self.image.height as usize - 1);
        for next in self.first + self.rows.len()..=last {
            let row = self.filtered_along_x(next);
            self.rows.push_back(row);
        }
        let eye = [0, 1, 2, 3].map(|i| self.filtered_along_y(y, &self.filters.eye[i], |row| &row.eye[i]));
        let colors = (0..self.image.width as usize)
            .map(|x| color::perceived(DVec3::new(eye[0][x], eye[1][x], eye[2][x] + eye[3][x])))
            .collect();
        let [gaussian, first, second] = &self.filters.feature;
        let edge_x = self.filtered_along_y(y, gaussian, |row| &row.feature[1]);
        let edge_y = self.filtered_along_y(y, first, |row| &row.feature[0]);
        let point_x = self.filtered_along_y(y, gaussian, |row| &row.feature[2]);
        let point_y = self.filtered_along_y(y, second, |row| &row.feature[0]);
        let length = |a: f64, b: f64| (a * a + b * b).sqrt();
        let features = (0..self.image.width as usize)
            .map(|x| [length(edge_x[x], edge_y[x]), length(point_x[x], point_y[x])])
            .collect();
        Row { colors, features }
    }

    fn filtered_along_x(&self, y: usize) -> AlongX {
        let width = self.image.width as usize;
        let radius = self.filters.radius();
        let pixels = &self.image.pixels[y * width..(y + 1) * width];
        let shown = pixels
            .iter()
            .map(|pixel| color::opponent((self.show)(DVec3::new(pixel[0] as f64, pixel[1] as f64, pixel[2] as f64))));
        let shown: Vec<DVec3> = shown.collect();
        let padded = |component: usize| -> Vec<f64> {
            let column = |i: usize| i.saturating_sub(radius).min(width - 1);
            (0..width + 2 * radius).map(|i| shown[column(i)][component]).collect()
        };
        let (achromatic, red_green, blue_yellow) = (padded(0), padded(1), padded(2));
        let filtered = |values: &[f64], filter: &[f64]| {
            let mut out = vec![0.0; width];
            let start = radius - filter.len() / 2;
            for (i, weight) in filter.iter().enumerate() {
                add_scaled(&mut out, &values[start + i..start + i + width], *weight);
            }
            out
        };
        let channels = [&achromatic, &red_green, &blue_yellow, &blue_yellow];
        let eye = [0, 1, 2, 3].map(|i| filtered(channels[i], &self.filters.eye[i]));
        let feature = [0, 1, 2].map(|i| filtered(&achromatic, &self.filters.feature[i]));
        AlongX { eye, feature }
    }

    fn filtered_along_y<'b>(
        &'b self,
        y: usize,
        filter: &[f64],
        channel: impl Fn(&'b AlongX) -> &'b Vec<f64>,
    ) -> Vec<f64> {
        let mut out = vec![0.0; self.image.width as usize];
        for (i, weight) in filter.iter().enumerate() {
            let row = (y + i).saturating_sub(filter.len() / 2).min(self.image.height as usize - 1);
            add_scaled(&mut out, channel(&self.rows[row - self.first]), *weight);
        }
        out
    }
}

fn add_scaled(out: &mut [f64], values: &[f64], weight: f64) {
    for (out, value) in out.iter_mut().zip(values) {
        *out += weight * value;
    }
}

/// The difference of two pixels' edges and points, whichever is larger, in [0, 1].
pub fn feature_difference(a: [f64; 2], b: [f64; 2]) -> f64 {
    let larger = (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
    libm::pow(larger / std::f64::consts::SQRT_2, FEATURE_EXPONENT)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn filters_have_the_widths_and_sums_of_the_paper() {
        for (pixels_per_degree, eye, feature) in [(super::super::PIXELS_PER_DEGREE, 21, 19), (30.0, 11, 9), (1.0, 3, 3)]
        {
            let filters = Filters::new(pixels_per_degree);
            assert!(filters.eye.iter().all(|filter| filter.len() == eye), "{}", filters.eye[0].len());
            assert!(filters.feature.iter().all(|filter| filter.len() == feature), "{}", filters.feature[0].len());
            let square = |filter: &[f64]| filter.iter().sum::<f64>().powi(2);
            let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-14, "{a} {b}");
            close(square(&filters.eye[0]), 1.0);
            close(square(&filters.eye[1]), 1.0);
            close(square(&filters.eye[2]) + square(&filters.eye[3]), 1.0);
            let signed = |filter: &[f64], sign: f64| filter.iter().map(|w| (w * sign).max(0.0)).sum::<f64>();
            close(signed(&filters.feature[0], 1.0), 1.0);
            for derivative in &filters.feature[1..] {
                close(signed(derivative, 1.0), 1.0);
                close(signed(derivative, -1.0), 1.0);
            }
        }
    }
}
