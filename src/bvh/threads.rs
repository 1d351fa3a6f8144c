//! Work shared among threads, while a scene is prepared.
//!
//! **Law:** how many threads there are changes no bit of any result: what is shared is cut by sizes alone, and answers come back
//! in the order of the questions.

use std::sync::Mutex;

/// Fewer rows than this are one thread's work: it takes less time than to start another.
const FEW_ROWS: usize = 1 << 14;

/// How many threads are to work on so many rows where `wanted` are asked for; 0 asks for one a core.
pub(crate) fn count(wanted: usize, rows: usize) -> usize {
    match wanted {
        0 if rows < FEW_ROWS => 1,
        0 => std::thread::available_parallelism().map_or(1, |cores| cores.get()),
        wanted => wanted,
    }
}

/// What `work` makes of every item, in the order of the items. Up to `threads` threads, of which the calling one is the first, take
/// one item after the other.
pub(crate) fn map<T: Send, R: Send>(threads: usize, items: Vec<T>, work: impl Fn(T) -> R + Sync) -> Vec<R> {
    let threads = threads.min(items.len());
    if threads <= 1 {
        return items.into_iter().map(work).collect();
    }
    let queue = Mutex::new(items.into_iter().enumerate());
    let worker = || {
        let mut done = Vec::new();
        loop {
            // A statement of its own, so that the queue is free again while the item is worked on.
            let next = queue.lock().expect("no worker panics").next();
            match next {
                Some((place, item)) => done.push((place, work(item))),
                None => return done,
            }
        }
    };
    let mut done = std::thread::scope(|scope| {
        // Where the system refuses to start a thread, those that there are do its work.
        let start = |_| std::thread::Builder::new().spawn_scoped(scope, worker).ok();
        let others: Vec<_> = (1..threads).map_while(start).collect();
        let own = worker();
        others.into_iter().fold(own, |mut all, other| {
            all.extend(other.join().expect("no worker panics"));
            all
        })
    });
    done.sort_unstable_by_key(|&(place, _)| place);
    done.into_iter().map(|(_, result)| result).collect()
}

/// Cuts `rows` into slices of the lengths `lengths`, in order; what is left over is in none.
pub(crate) fn cut<T>(rows: &mut [T], lengths: impl IntoIterator<Item = usize>) -> Vec<&mut [T]> {
    let mut rest = rows;
    let part = |length| {
        let (part, others) = std::mem::take(&mut rest).split_at_mut(length);
        rest = others;
        part
    };
    lengths.into_iter().map(part).collect()
}

/// The ranges of `length` rows that `count` rows are cut into; the last may be shorter.
pub(crate) fn ranges(count: usize, length: usize) -> Vec<std::ops::Range<usize>> {
    (0..count).step_by(length).map(|first| first..(first + length).min(count)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_the_order_of_the_items_whatever_the_number_of_threads() {
        let expected: Vec<usize> = (0..1000).map(|i| i * i).collect();
        for threads in [1, 2, 3, 17] {
            assert_eq!(map(threads, (0..1000).collect(), |i: usize| i * i), expected, "{threads} threads");
        }
        assert!(map(4, Vec::new(), |i: usize| i).is_empty());
    }

    #[test]
    fn cuts_and_ranges_cover_all_rows_once() {
        assert_eq!(ranges(10, 4), [0..4, 4..8, 8..10]);
        assert!(ranges(0, 4).is_empty());
        let mut rows = [0, 1, 2, 3, 4, 5];
        assert_eq!(cut(&mut rows, [2, 0, 3]), [&mut [0, 1][..], &mut [], &mut [2, 3, 4]]);
    }
}
