//! Lists that are filled anew in every step and keep their memory.

/// A list whose old items are worth nothing.
pub(crate) trait Refill<T: Clone> {
    /// Holds these items instead.
    fn refill(&mut self, items: impl IntoIterator<Item = T>);
    /// Holds so many times one value instead.
    fn reset(&mut self, count: usize, value: T);
}

impl<T: Clone> Refill<T> for Vec<T> {
    #[inline]
    fn refill(&mut self, items: impl IntoIterator<Item = T>) {
        self.clear();
        self.extend(items);
    }

    #[inline]
    fn reset(&mut self, count: usize, value: T) {
        self.clear();
        self.resize(count, value);
    }
}
