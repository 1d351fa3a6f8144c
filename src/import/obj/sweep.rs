//! A simple polygon of very many corners into triangles, in a time that grows like n log n: a line sweeps it from top to bottom
//! (de Berg et al., *Computational Geometry*, chapter 3).
//!
//! What of the polygon the line cuts is a row of spans, each between an edge on its left and one on its right. Above the line a
//! span has a monotone piece of polygon that is not cut to the end yet (`Piece`). Where a span splits or two become one, a
//! diagonal to the vertex before divides the pieces, so that they stay monotone.

use crate::import::obj::point_tree::turn;
use glam::DVec2;

/// Where a chain of vertices runs down.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Left,
    Right,
}

/// A monotone piece: the vertices that wait for their triangles. Behind the first all of them are on one side.
struct Piece {
    waiting: Vec<u32>,
    side: Side,
}

impl Piece {
    fn new(first: u32) -> Piece {
        Piece { waiting: vec![first], side: Side::Left }
    }
}

/// A part of the sweep line inside the polygon. An edge is named by the corner that it leads away from.
struct Span {
    /// Leads down.
    left: usize,
    /// Leads up.
    right: usize,
    piece: Piece,
    /// The piece on the right of a vertex where two spans have become one, until the next vertex parts them.
    second: Option<Piece>,
}

/// The spans from left to right, in parts of [`MOST_IN_PART`] at most, none empty.
#[derive(Default)]
struct Row(Vec<Vec<u32>>);

/// A place in a row: part, and place in the part.
type Place = (usize, usize);

const MOST_IN_PART: usize = 512;

impl Row {
    /// The first place from which on `is_left` no longer holds.
    fn place(&self, is_left: impl Fn(u32) -> bool) -> Place {
        match self.0.partition_point(|part| is_left(part[0])) {
            0 => (0, 0),
            parts => (parts - 1, self.0[parts - 1].partition_point(|&span| is_left(span))),
        }
    }

    /// The span before a place.
    fn before(&self, (part, place): Place) -> Option<u32> {
        self.0.get(part)?.get(place.checked_sub(1)?).copied()
    }

    /// The span at a place.
    fn at(&self, (part, place): Place) -> Option<u32> {
        let first_of_next = || self.0.get(part + 1)?.first();
        self.0.get(part)?.get(place).or_else(first_of_next).copied()
    }

    fn insert(&mut self, (number, place): Place, span: u32) {
        let Some(part) = self.0.get_mut(number) else { return self.0.push(vec![span]) };
        part.insert(place, span);
        if part.len() > MOST_IN_PART {
            let half = part.split_off(MOST_IN_PART / 2);
            self.0.insert(number + 1, half);
        }
    }

    /// Takes out the span at a place; `None` if another is there.
    fn remove(&mut self, (mut number, mut place): Place, span: u32) -> Option<()> {
        if self.0.get(number)?.len() == place {
            (number, place) = (number + 1, 0);
        }
        let part = self.0.get_mut(number)?;
        if *part.get(place)? != span {
            return None;
        }
        part.remove(place);
        if part.is_empty() {
            self.0.remove(number);
        }
        Some(())
    }
}

/// The n - 2 triangles of a counter-clockwise polygon, as corner numbers in its winding; `None` if it crosses itself, or touches
/// itself or folds back on itself so that this cannot be told from crossing.
pub fn sweep(points: &[DVec2]) -> Option<Vec<[u32; 3]>> {
    let n = points.len();
    let mut order: Vec<u32> = (0..n as u32).collect();
    // Of equally high ones the left first: as if the line were tilted a little. Zeros have no sign here.
    let key = |vertex: u32| points[vertex as usize] + DVec2::ZERO;
    order.sort_unstable_by(|&a, &b| {
        let (p, q) = (key(a), key(b));
        q.y.total_cmp(&p.y).then(p.x.total_cmp(&q.x)).then(a.cmp(&b))
    });
    let mut rank = vec![0; n];
    order.iter().enumerate().for_each(|(place, &vertex)| rank[vertex as usize] = place as u32);
    let mut sweep = Sweep {
        points,
        spans: Vec::new(),
        row: Row::default(),
        span_of: vec![u32::MAX; n],
        triangles: Vec::with_capacity(n - 2),
    };
    for &vertex in &order {
        let at = vertex as usize;
        let [before, after] = [(at + n - 1) % n, (at + 1) % n];
        let turns = turn(points[before], points[at], points[after]);
        match [rank[before] < rank[at], rank[after] < rank[at]] {
            [true, false] => sweep.go_on(at, before, Side::Left)?,
            [false, true] => sweep.go_on(at, before, Side::Right)?,
            [false, false] if turns > 0.0 => sweep.start(at, before)?,
            [false, false] if turns < 0.0 => sweep.split(at, before)?,
            [true, true] if turns > 0.0 => sweep.end(at, before)?,
            [true, true] if turns < 0.0 => sweep.merge(at, before)?,
            _ => return None,
        }
    }
    // What rounding may have hidden.
    let doubled = |t: &[u32; 3]| turn(points[t[0] as usize], points[t[1] as usize], points[t[2] as usize]);
    let whole: f64 = points.windows(2).map(|edge| (edge[0] - points[0]).perp_dot(edge[1] - points[0])).sum();
    let none_turned = sweep.triangles.iter().all(|t| doubled(t) >= -SLACK * whole);
    let covered: f64 = sweep.triangles.iter().map(doubled).sum();
    let whole_covered = (covered - whole).abs() <= SLACK * whole;
    (sweep.triangles.len() == n - 2 && none_turned && whole_covered).then_some(sweep.triangles)
}

/// Areas that do not count, of that of the polygon.
const SLACK: f64 = 1e-9;

struct Sweep<'a> {
    points: &'a [DVec2],
    /// All spans that there have been.
    spans: Vec<Span>,
    row: Row,
    /// By edge, the span that it bounds.
    span_of: Vec<u32>,
    triangles: Vec<[u32; 3]>,
}

impl Sweep<'_> {
    /// The corner that an edge leads to.
    fn end_of(&self, edge: usize) -> usize {
        if edge + 1 == self.points.len() { 0 } else { edge + 1 }
    }

    /// How a vertex lies to an edge: above 0 to the left of the way it leads.
    fn side_of(&self, edge: usize, vertex: usize) -> f64 {
        turn(self.points[edge], self.points[self.end_of(edge)], self.points[vertex])
    }

    /// The place behind the spans whose left edge is to the left of a vertex.
    fn place(&self, vertex: usize) -> Place {
        self.row.place(|span| self.side_of(self.spans[span as usize].left, vertex) > 0.0)
    }

    /// `None` if two edges cross that have become neighbours on the line: where any cross, two such do (Shamos and Hoey 1976).
    fn neighbours(&self, first: Option<usize>, second: Option<usize>) -> Option<()> {
        let (Some(first), Some(second)) = (first, second) else { return Some(()) };
        let parts = |a: usize, b: usize| self.side_of(a, b) * self.side_of(a, self.end_of(b)) < 0.0;
        (!(parts(first, second) && parts(second, first))).then_some(())
    }

    /// The right edge of the span before a place.
    fn edge_before(&self, place: Place) -> Option<usize> {
        self.row.before(place).map(|span| self.spans[span as usize].right)
    }

    /// The left edge of the span at a place.
    fn edge_at(&self, place: Place) -> Option<usize> {
        self.row.at(place).map(|span| self.spans[span as usize].left)
    }

    fn span(&mut self, edge: usize) -> Option<&mut Span> {
        self.spans.get_mut(self.span_of[edge] as usize)
    }

    fn insert(&mut self, place: Place, span: Span) {
        let number = self.spans.len() as u32;
        (self.span_of[span.left], self.span_of[span.right]) = (number, number);
        self.spans.push(span);
        self.row.insert(place, number);
    }

    /// Adds a vertex to a piece, on a side, and cuts what it can see.
    fn add(&mut self, piece: &mut Piece, vertex: u32, side: Side) {
        if piece.waiting.len() > 1 && piece.side != side {
            self.close(piece, vertex);
        }
        piece.side = side;
        while let [.., a, b] = piece.waiting[..] {
            let triangle = in_winding([a, b, vertex], side);
            let [a, b, c] = triangle.map(|vertex| self.points[vertex as usize]);
            if turn(a, b, c) <= 0.0 {
                break;
            }
            self.triangles.push(triangle);
            piece.waiting.pop();
        }
        piece.waiting.push(vertex);
    }

    /// Cuts all of a piece off from a vertex that sees it; its last vertex waits on.
    fn close(&mut self, piece: &mut Piece, vertex: u32) {
        let side = piece.side;
        self.triangles.extend(piece.waiting.windows(2).map(|pair| in_winding([pair[0], pair[1], vertex], side)));
        piece.waiting.drain(..piece.waiting.len() - 1);
    }

    /// A vertex where an edge above ends and one below begins.
    fn go_on(&mut self, at: usize, before: usize, side: Side) -> Option<()> {
        let (ending, beginning) = if side == Side::Left { (before, at) } else { (at, before) };
        let number = self.span_of[ending];
        let place = self.place(at);
        let found = if side == Side::Left { self.row.at(place) } else { self.row.before(place) };
        if found != Some(number) {
            return None;
        }
        self.reach(number, at, side)?;
        let span = &mut self.spans[number as usize];
        let edge = if side == Side::Left { &mut span.left } else { &mut span.right };
        if *edge != ending {
            return None;
        }
        *edge = beginning;
        let (left, right) = (span.left, span.right);
        self.span_of[beginning] = number;
        self.neighbours(Some(left), Some(right))?;
        match side {
            Side::Left => self.neighbours(self.edge_before(place), Some(left)),
            Side::Right => self.neighbours(Some(right), self.edge_at(place)),
        }
    }

    /// Adds a vertex to a span, on a side; of two pieces the one on the other side goes on.
    fn reach(&mut self, number: u32, at: usize, side: Side) -> Option<()> {
        let span = self.spans.get_mut(number as usize)?;
        let second = span.second.take();
        let mut piece = std::mem::replace(&mut span.piece, Piece::new(0));
        if let Some(mut second) = second {
            // On the left the left piece ends: its right chain ends in the vertex where the two met.
            if side == Side::Left {
                std::mem::swap(&mut piece, &mut second);
            }
            self.close(&mut second, at as u32);
        }
        self.add(&mut piece, at as u32, side);
        self.spans[number as usize].piece = piece;
        Some(())
    }

    /// A top of the polygon.
    fn start(&mut self, at: usize, before: usize) -> Option<()> {
        let place = self.place(at);
        if let Some(span) = self.row.before(place)
            && self.side_of(self.spans[span as usize].right, at) > 0.0
        {
            return None; // inside
        }
        self.neighbours(self.edge_before(place), Some(at))?;
        self.neighbours(Some(before), self.edge_at(place))?;
        self.insert(place, Span { left: at, right: before, piece: Piece::new(at as u32), second: None });
        Some(())
    }

    /// A top of what is outside: the span around it becomes two.
    fn split(&mut self, at: usize, before: usize) -> Option<()> {
        let place = self.place(at);
        let number = self.row.before(place)?;
        let right = self.spans[number as usize].right;
        if self.side_of(right, at) <= 0.0 {
            return None; // outside
        }
        self.neighbours(Some(self.spans[number as usize].left), Some(before))?;
        self.neighbours(Some(at), Some(right))?;
        let span = &mut self.spans[number as usize];
        span.right = before;
        let first = std::mem::replace(&mut span.piece, Piece::new(0));
        let (mut first, mut second) = match (span.second.take(), first.side) {
            (Some(second), _) => (first, second),
            // The vertex before it sees it: the side of that one's chain decides which piece is new.
            (None, Side::Left) => (Piece::new(*first.waiting.last()?), first),
            (None, Side::Right) => {
                let second = Piece::new(*first.waiting.last()?);
                (first, second)
            }
        };
        self.add(&mut first, at as u32, Side::Right);
        self.add(&mut second, at as u32, Side::Left);
        self.spans[number as usize].piece = first;
        self.span_of[before] = number;
        self.insert(place, Span { left: at, right, piece: second, second: None });
        Some(())
    }

    /// A bottom of the polygon.
    fn end(&mut self, at: usize, before: usize) -> Option<()> {
        let number = self.span_of[before];
        if number != self.span_of[at] {
            return None;
        }
        self.row.remove(self.place(at), number)?;
        let place = self.place(at);
        self.neighbours(self.edge_before(place), self.edge_at(place))?;
        let span = self.span(at)?;
        let second = span.second.take();
        let mut first = std::mem::replace(&mut span.piece, Piece::new(0));
        self.close(&mut first, at as u32);
        if let Some(mut second) = second {
            self.close(&mut second, at as u32);
        }
        Some(())
    }

    /// A bottom of what is outside: two spans become one.
    fn merge(&mut self, at: usize, before: usize) -> Option<()> {
        let (left, right) = (self.span_of[at], self.span_of[before]);
        if left == right {
            return None;
        }
        self.row.remove(self.place(at), right)?;
        self.reach(left, at, Side::Right)?;
        self.reach(right, at, Side::Left)?;
        let second = self.spans.get_mut(right as usize)?;
        let (edge, piece) = (second.right, std::mem::replace(&mut second.piece, Piece::new(0)));
        let first = &mut self.spans[left as usize];
        if first.right != at {
            return None;
        }
        (first.right, first.second) = (edge, Some(piece));
        let outer = first.left;
        self.span_of[edge] = left;
        self.neighbours(Some(outer), Some(edge))
    }
}

/// Two vertices of a chain, from the top, and one that sees them, in the winding of the polygon.
fn in_winding([a, b, c]: [u32; 3], chain: Side) -> [u32; 3] {
    if chain == Side::Left { [a, b, c] } else { [c, b, a] }
}
