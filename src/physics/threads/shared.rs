//! Memory that several threads write at once, each its own part of it.
#![allow(unsafe_code)]

use std::marker::PhantomData;

/// A mutable slice, handed to several threads that agree among themselves who writes what: in the
/// solver by colouring, since constraints of one colour share no body that moves.
///
/// The borrow checker cannot see that agreement: a constraint's bodies are any two of the slice.
/// Splitting the slice would need a copy of every body for every worker and pass (64 bytes for 30
/// of arithmetic), atomics would make each of eight numbers a store of its own.
#[derive(Debug)]
pub(crate) struct Shared<'a, T> {
    first: *mut T,
    len: usize,
    lifetime: PhantomData<&'a mut [T]>,
}

impl<T> Clone for Shared<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Shared<'_, T> {}

// SAFETY: it is a `&mut [T]` whose elements go to one thread at a time, as its users promise; `T: Send` lets
// them go there.
unsafe impl<T: Send> Send for Shared<'_, T> {}
// SAFETY: as above; sharing the handle shares no element.
unsafe impl<T: Send> Sync for Shared<'_, T> {}

impl<'a, T> Shared<'a, T> {
    /// Takes the slice over for as long as the handle lives.
    pub fn new(slice: &'a mut [T]) -> Self {
        Self { first: slice.as_mut_ptr(), len: slice.len(), lifetime: PhantomData }
    }

    /// Number of elements.
    pub fn len(self) -> usize {
        self.len
    }

    /// A copy of one element.
    ///
    /// # Safety
    /// Nobody may be writing it at the same time.
    ///
    /// # Panics
    /// Past the end.
    #[inline]
    pub unsafe fn read(self, index: usize) -> T
    where
        T: Copy,
    {
        assert!(index < self.len);
        // SAFETY: within the slice; not being written, as the caller promises.
        unsafe { *self.first.add(index) }
    }

    /// One element, to look at.
    ///
    /// # Safety
    /// Nobody may write it while the reference lives.
    ///
    /// # Panics
    /// Past the end.
    #[inline]
    pub unsafe fn get(self, index: usize) -> &'a T {
        assert!(index < self.len);
        // SAFETY: within the slice; not being written, as the caller promises.
        unsafe { &*self.first.add(index) }
    }

    /// One element, for this thread alone.
    ///
    /// # Safety
    /// Nobody else may read or write it while the reference lives.
    ///
    /// # Panics
    /// Past the end.
    #[inline]
    pub unsafe fn element(self, index: usize) -> &'a mut T {
        assert!(index < self.len);
        // SAFETY: within the slice; nobody else has it, as the caller promises.
        unsafe { &mut *self.first.add(index) }
    }
}
