//! Sets of small numbers, one bit each: walked in order, at the price of a word where 64 are absent.

use std::ops::Range;

/// A set of indices.
#[derive(Clone, Debug, Default)]
pub(crate) struct BitSet {
    words: Vec<u64>,
}

/// Numbers in a word.
pub(crate) const WORD: usize = u64::BITS as usize;

impl BitSet {
    /// Whether it has the index.
    #[inline]
    pub fn contains(&self, index: u32) -> bool {
        self.word(index as usize / WORD) >> (index % u64::BITS) & 1 != 0
    }

    /// The word of that place, 0 beyond the last.
    #[inline]
    fn word(&self, place: usize) -> u64 {
        self.words.get(place).copied().unwrap_or(0)
    }

    /// Puts an index in or takes it out.
    pub fn set(&mut self, index: u32, is_in: bool) {
        let place = index as usize / WORD;
        if place >= self.words.len() {
            if !is_in {
                return;
            }
            self.words.resize(place + 1, 0);
        }
        let bit = 1 << (index % u64::BITS);
        if is_in {
            self.words[place] |= bit;
        } else {
            self.words[place] &= !bit;
        }
    }

    /// Takes all out.
    pub fn clear(&mut self) {
        self.words.clear();
    }

    /// How many there are.
    pub fn len(&self) -> u32 {
        self.words.iter().map(|word| word.count_ones()).sum()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.words.iter().all(|&word| word == 0)
    }

    /// Puts all of another in.
    pub fn add(&mut self, other: &Self) {
        if self.words.len() < other.words.len() {
            self.words.resize(other.words.len(), 0);
        }
        self.words.iter_mut().zip(&other.words).for_each(|(word, other)| *word |= other);
    }

    /// How many are in it and in another.
    pub fn common(&self, other: &Self) -> u32 {
        self.words.iter().zip(&other.words).map(|(word, other)| (word & other).count_ones()).sum()
    }

    /// All of it, ascending.
    pub fn iter(&self) -> impl Iterator<Item = u32> + Clone + '_ {
        ones(&self.words)
    }

    /// What is in it and in another, ascending.
    pub fn both(&self, other: &Self) -> impl Iterator<Item = u32> + Clone {
        walk(self.words.iter().zip(&other.words).map(|(word, other)| word & other))
    }

    /// What is in it and in one of two others, ascending.
    pub fn with_either(&self, one: &Self, other: &Self) -> impl Iterator<Item = u32> + Clone {
        walk(self.words.iter().enumerate().map(move |(place, own)| own & (one.word(place) | other.word(place))))
    }

    /// What of a range that begins with a multiple of 64 is neither in it nor in another, ascending.
    pub fn in_neither<'t>(
        &'t self,
        other: &'t Self,
        Range { start, end }: Range<u32>,
    ) -> impl Iterator<Item = u32> + Clone + 't {
        debug_assert_eq!(start % u64::BITS, 0);
        let words = (start / u64::BITS..end.div_ceil(u64::BITS)).map(move |place| {
            let left = end - place * u64::BITS;
            let range = if left < u64::BITS { (1 << left) - 1 } else { u64::MAX };
            !(self.word(place as usize) | other.word(place as usize)) & range
        });
        walk(words).map(move |index| start + index)
    }

    /// The words from a multiple of 64 on, for a run of indices: see [`ones`].
    pub fn words(&self, first: usize, count: usize) -> &[u64] {
        debug_assert_eq!(first % WORD, 0);
        let start = (first / WORD).min(self.words.len());
        &self.words[start..(start + count.div_ceil(WORD)).min(self.words.len())]
    }

    /// Follows indices to new ones; those without are left out.
    pub fn remap(&mut self, new_index: &[Option<u32>]) {
        let mut renamed = Self::default();
        for index in self.iter().filter_map(|index| new_index.get(index as usize).copied().flatten()) {
            renamed.set(index, true);
        }
        *self = renamed;
    }
}

/// The places of the ones, ascending.
pub(crate) fn ones(words: &[u64]) -> impl Iterator<Item = u32> + Clone + '_ {
    walk(words.iter().copied())
}

/// Walks the ones of words.
#[inline]
fn walk(mut words: impl Iterator<Item = u64> + Clone) -> impl Iterator<Item = u32> + Clone {
    // What is left of the present word, and where it ends.
    let (mut word, mut end) = (0, 0);
    std::iter::from_fn(move || {
        while word == 0 {
            word = words.next()?;
            end += u64::BITS;
        }
        let place = end - u64::BITS + word.trailing_zeros();
        word &= word - 1;
        Some(place)
    })
}

#[cfg(test)]
mod tests {
    use super::BitSet;

    #[test]
    fn it_walks_what_is_in_and_what_is_not() {
        for count in [0, 1, 63, 64, 65, 200] {
            let in_it = |index: u32| index.is_multiple_of(3) || index % 64 == 63;
            let mut set = BitSet::default();
            (0..count).for_each(|index| set.set(index, in_it(index)));
            let (present, absent): (Vec<u32>, Vec<u32>) = (0..count).partition(|&index| in_it(index));
            assert_eq!(set.iter().collect::<Vec<_>>(), present);
            let none = BitSet::default();
            assert_eq!(set.in_neither(&none, 0..count).collect::<Vec<_>>(), absent);
            assert_eq!(none.in_neither(&set, 0..count).collect::<Vec<_>>(), absent);
            let mut fives = BitSet::default();
            (0..count).for_each(|index| fives.set(index, index.is_multiple_of(5)));
            let neither: Vec<u32> = absent.iter().copied().filter(|index| *index >= 64 && index % 5 != 0).collect();
            assert_eq!(set.in_neither(&fives, 64..count.max(64)).collect::<Vec<_>>(), neither);
            assert_eq!((set.len() as usize, set.is_empty()), (present.len(), present.is_empty()));
            assert!((0..count + 99).all(|index| set.contains(index) == (index < count && in_it(index))));
            let both = present.iter().filter(|&&index| fives.contains(index)).count();
            assert_eq!((set.common(&fives), fives.common(&set)), (both as u32, both as u32));
            let mut sum = BitSet::default();
            [&fives, &set, &none].into_iter().for_each(|set| sum.add(set));
            assert!((0..count).all(|index| sum.contains(index) == (in_it(index) || index.is_multiple_of(5))));
            present.iter().for_each(|&index| set.set(index, false));
            assert_eq!((set.len(), set.in_neither(&none, 0..count).count()), (0, count as usize));
        }
    }

    #[test]
    fn indices_follow_what_they_stand_for() {
        let mut set = BitSet::default();
        [2, 3, 70].into_iter().for_each(|index| set.set(index, true));
        let new_index: Vec<Option<u32>> = (0..80).map(|index: u32| (index != 3).then_some(index / 2)).collect();
        set.remap(&new_index);
        assert_eq!(set.iter().collect::<Vec<_>>(), [1, 35]);
    }
}
