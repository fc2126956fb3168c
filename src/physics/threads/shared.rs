//! Memory that several threads write at once, each its own part of it.
#![allow(unsafe_code)]

use std::marker::PhantomData;

use super::Claims;

/// A mutable slice, handed to several threads that agree among themselves who writes what. What the solver agrees on
/// stands in `solver::impulse`; debug builds assert it ([`super::claims`]).
///
/// The borrow checker cannot see that agreement: a constraint's bodies are any two of the slice.
/// Splitting the slice would need a copy of every body for every worker and pass (64 bytes for 30
/// of arithmetic), atomics would make each of eight numbers a store of its own.
#[derive(Debug)]
pub(crate) struct Shared<'a, T> {
    first: *mut T,
    len: usize,
    #[cfg(debug_assertions)]
    claims: &'a Claims,
    lifetime: PhantomData<&'a mut [T]>,
}

impl<T> Clone for Shared<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Shared<'_, T> {}

// SAFETY: handles on other threads give out `&mut T`, which `T: Send` allows, and `&T`, which `T: Sync` allows; that
// no `&mut T` meets another reference is what the callers of its methods promise. A handle is `Copy`, so that to send
// one is to share it.
unsafe impl<T: Send + Sync> Send for Shared<'_, T> {}
// SAFETY: as above.
unsafe impl<T: Send + Sync> Sync for Shared<'_, T> {}

impl<'a, T> Shared<'a, T> {
    /// Takes the slice over for as long as the handle lives.
    pub fn new(slice: &'a mut [T], claims: &'a mut Claims) -> Self {
        claims.cover(slice.len());
        Self::with(slice, claims)
    }

    /// As [`Self::new`], of one of several slices whose elements of one index are claimed together.
    pub fn with(slice: &'a mut [T], claims: &'a Claims) -> Self {
        #[cfg(not(debug_assertions))]
        let _ = claims;
        Self {
            first: slice.as_mut_ptr(),
            len: slice.len(),
            #[cfg(debug_assertions)]
            claims,
            lifetime: PhantomData,
        }
    }

    /// Number of elements.
    pub fn len(self) -> usize {
        self.len
    }

    /// A pointer to one element.
    ///
    /// # Panics
    /// Past the end; in debug builds, where another claimant has the element and one of the two writes.
    #[inline]
    fn claim(self, index: usize, _writes: bool) -> *mut T {
        assert!(index < self.len);
        #[cfg(debug_assertions)]
        self.claims.claim(index, _writes);
        self.first.wrapping_add(index)
    }

    /// A copy of one element.
    ///
    /// # Safety
    /// Nobody may be writing it at the same time.
    #[inline]
    pub unsafe fn read(self, index: usize) -> T
    where
        T: Copy,
    {
        // SAFETY: within the slice; not being written, as the caller promises.
        unsafe { *self.claim(index, false) }
    }

    /// One element, to look at.
    ///
    /// # Safety
    /// Nobody may write it while the reference lives.
    #[inline]
    pub unsafe fn get(self, index: usize) -> &'a T {
        // SAFETY: within the slice; not being written, as the caller promises.
        unsafe { &*self.claim(index, false) }
    }

    /// One element, for this thread alone.
    ///
    /// # Safety
    /// Nobody else may read or write it while the reference lives.
    #[inline]
    pub unsafe fn element(self, index: usize) -> &'a mut T {
        // SAFETY: within the slice; nobody else has it, as the caller promises.
        unsafe { &mut *self.claim(index, true) }
    }
}
