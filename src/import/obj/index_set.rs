//! A set of numbers below a bound that finds the next member behind a place without a look at what lies between.

/// Numbers below a bound: bits, and above each 64 words of bits one bit a word that says whether the word has any.
#[derive(Clone, Debug)]
pub struct IndexSet {
    /// The words of the members, then those that mark them, and so on up to a single word.
    levels: Vec<Vec<u64>>,
}

impl IndexSet {
    /// The empty set of numbers below `bound`.
    pub fn new(bound: usize) -> IndexSet {
        let mut levels = Vec::new();
        let mut size = bound;
        loop {
            size = size.div_ceil(64).max(1);
            levels.push(vec![0; size]);
            if size == 1 {
                return IndexSet { levels };
            }
        }
    }

    /// Puts `index` in.
    pub fn insert(&mut self, mut index: usize) {
        for level in &mut self.levels {
            level[index / 64] |= 1 << (index % 64);
            index /= 64;
        }
    }

    /// Takes `index` out, if it is in.
    pub fn remove(&mut self, mut index: usize) {
        for level in &mut self.levels {
            let word = &mut level[index / 64];
            *word &= !(1 << (index % 64));
            if *word != 0 {
                return;
            }
            index /= 64;
        }
    }

    /// The first member from `start` on; behind the last, the first of all.
    pub fn next(&self, start: usize) -> Option<usize> {
        self.at_least(start).or_else(|| self.at_least(0))
    }

    /// The least member that is at least `start`.
    fn at_least(&self, start: usize) -> Option<usize> {
        let mut from = start;
        for (height, level) in self.levels.iter().enumerate() {
            let word = level.get(from / 64)? & u64::MAX << (from % 64);
            if word != 0 {
                let found = from / 64 * 64 + word.trailing_zeros() as usize;
                // Down again, along the first bits of the words.
                let down = |index: usize, level: &Vec<u64>| index * 64 + level[index].trailing_zeros() as usize;
                return Some(self.levels[..height].iter().rev().fold(found, down));
            }
            from = from / 64 + 1;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn it_finds_what_an_ordered_set_finds() {
        for bound in [1, 63, 64, 65, 4095, 4096, 4097, 300_000] {
            let (mut set, mut plain) = (IndexSet::new(bound), BTreeSet::new());
            let mut random = 1u64;
            for step in 0..2000 {
                random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let index = (random >> 33) as usize % bound;
                if step % 3 == 0 {
                    set.insert(index);
                    plain.insert(index);
                } else if let Some(&member) = plain.range(index..).next().filter(|_| step % 2 == 0) {
                    set.remove(member);
                    plain.remove(&member);
                } else {
                    set.remove(index);
                    plain.remove(&index);
                }
                let expected = plain.range(index..).next().or(plain.first()).copied();
                assert_eq!(set.next(index), expected, "{bound} {index}");
            }
        }
    }
}
