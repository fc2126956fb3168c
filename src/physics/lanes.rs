//! The scalars that the kernels run on: one constraint at a time in `f64`, or eight in `f32`
//! lanes, both from the same source.
//!
//! Bodies lie in memory one after the other, each a few [`Record`]s of eight numbers; a kernel
//! wants the same number of eight bodies in one register. Reading is eight loads and an 8 × 8
//! transpose, writing the reverse: cheaper than gathering number by number.
#![allow(unsafe_code)]

use std::fmt::Debug;

use nalgebra::{SimdRealField, Vector3};
use simba::simd::WideF32x8;
use wide::f32x8;

use super::{Scalar, Shared};

/// Constraints that a block of any kind of lanes can hold.
pub(crate) const WIDTH: usize = 8;

/// Flags a body that a block reads but must not write: one that no constraint moves. Several lanes
/// may share it.
pub(crate) const READ_ONLY: u32 = 1 << 31;

/// Eight numbers of one body or constraint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct Record<S>(pub [S; WIDTH]);

/// As many scalars as a kernel takes at once.
pub(crate) trait Lanes: SimdRealField + Copy + Debug + Default + Send + Sync + 'static {
    /// Of one lane.
    type Scalar: Scalar + Default + Send + Sync + Debug;
    /// How many.
    const COUNT: usize;
    /// The same number in every lane.
    fn of(value: f64) -> Self;
    /// One number for each lane.
    fn each(value: impl FnMut(usize) -> Self::Scalar) -> Self;
    /// The number of one lane.
    fn lane(self, lane: usize) -> Self::Scalar;
    /// The numbers of one record for each lane, kept in `f32` whatever the lanes are.
    fn take(rows: [&Record<f32>; WIDTH]) -> [Self; WIDTH];
    /// The records back.
    fn give(values: [Self; WIDTH]) -> [Record<f32>; WIDTH];
    /// The numbers of the records named, lane by lane.
    ///
    /// # Safety
    /// Nobody may be writing the records named.
    unsafe fn gather(records: Shared<Record<Self::Scalar>>, indices: &[u32; WIDTH]) -> [Self; WIDTH];
    /// Writes them back, but not to what is [`READ_ONLY`].
    ///
    /// # Safety
    /// Nobody else may be reading or writing the records that are not [`READ_ONLY`].
    unsafe fn scatter(values: [Self; WIDTH], records: Shared<Record<Self::Scalar>>, indices: &[u32; WIDTH]);
}

impl Lanes for f64 {
    type Scalar = f64;
    const COUNT: usize = 1;

    fn of(value: f64) -> Self {
        value
    }

    fn each(mut value: impl FnMut(usize) -> f64) -> Self {
        value(0)
    }

    fn lane(self, _: usize) -> f64 {
        self
    }

    fn take(rows: [&Record<f32>; WIDTH]) -> [Self; WIDTH] {
        rows[0].0.map(f64::from)
    }

    fn give(values: [Self; WIDTH]) -> [Record<f32>; WIDTH] {
        [Record(values.map(|number| number as f32)); WIDTH]
    }

    unsafe fn gather(records: Shared<Record<f64>>, indices: &[u32; WIDTH]) -> [Self; WIDTH] {
        // SAFETY: as the caller promises.
        unsafe { records.read((indices[0] & !READ_ONLY) as usize).0 }
    }

    unsafe fn scatter(values: [Self; WIDTH], records: Shared<Record<f64>>, indices: &[u32; WIDTH]) {
        if indices[0] & READ_ONLY == 0 {
            // SAFETY: as the caller promises.
            unsafe { records.element(indices[0] as usize).0 = values };
        }
    }
}

impl Lanes for WideF32x8 {
    type Scalar = f32;
    const COUNT: usize = WIDTH;

    #[inline]
    fn of(value: f64) -> Self {
        Self(f32x8::splat(value as f32))
    }

    #[inline]
    fn each(value: impl FnMut(usize) -> f32) -> Self {
        Self(f32x8::from(std::array::from_fn(value)))
    }

    #[inline]
    fn lane(self, lane: usize) -> f32 {
        self.0.to_array()[lane]
    }

    #[inline]
    fn take(rows: [&Record<f32>; WIDTH]) -> [Self; WIDTH] {
        f32x8::transpose(rows.map(|row| f32x8::from(row.0))).map(Self)
    }

    #[inline]
    fn give(values: [Self; WIDTH]) -> [Record<f32>; WIDTH] {
        f32x8::transpose(values.map(|lanes| lanes.0)).map(|row| Record(row.to_array()))
    }

    #[inline]
    unsafe fn gather(records: Shared<Record<f32>>, indices: &[u32; WIDTH]) -> [Self; WIDTH] {
        // SAFETY: as the caller promises.
        let rows = indices.map(|index| f32x8::from(unsafe { records.read((index & !READ_ONLY) as usize) }.0));
        f32x8::transpose(rows).map(Self)
    }

    #[inline]
    unsafe fn scatter(values: [Self; WIDTH], records: Shared<Record<f32>>, indices: &[u32; WIDTH]) {
        let rows = f32x8::transpose(values.map(|lanes| lanes.0));
        for (row, &index) in rows.into_iter().zip(indices) {
            if index & READ_ONLY == 0 {
                // SAFETY: as the caller promises.
                unsafe { records.element(index as usize).0 = row.to_array() };
            }
        }
    }
}

/// a·b, fused.
#[inline]
pub(crate) fn dot<L: Lanes>(a: &Vector3<L>, b: &Vector3<L>) -> L {
    a.x.simd_mul_add(b.x, a.y.simd_mul_add(b.y, a.z * b.z))
}

/// a + b s, fused.
#[inline]
pub(crate) fn add_scaled<L: Lanes>(a: &Vector3<L>, b: &Vector3<L>, s: L) -> Vector3<L> {
    Vector3::new(b.x.simd_mul_add(s, a.x), b.y.simd_mul_add(s, a.y), b.z.simd_mul_add(s, a.z))
}

/// The first three numbers.
#[inline]
pub(crate) fn vector<L: Copy>(numbers: &[L]) -> Vector3<L> {
    Vector3::new(numbers[0], numbers[1], numbers[2])
}

/// The reciprocal where there is something to divide by, else 0.
#[inline]
pub(crate) fn inverse<L: Lanes>(value: L) -> L {
    let least = L::of(1e-30);
    (L::one() / value.simd_max(least)).select(value.simd_gt(least), L::zero())
}
