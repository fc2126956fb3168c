//! How blocks on the diagonal are inverted, and what is done where they have no inverse.
//!
//! Blocks are slices, columns one after the other.

use super::layout::{Number, with_rows};

/// A way to factor a block on the diagonal and to divide by it.
pub(crate) trait Pivot<N> {
    /// Products are summed into their target with one rounding each (FMA), or summed first.
    const IS_FUSED: bool;
    /// Factors a block of `n` rows where it stands. False if it is refused.
    fn factor(block: &mut [N], n: usize) -> bool;
    /// `quotient` = `block` D⁻¹ for a block of so many rows and `n` columns; it has the values of `block` beforehand.
    fn divide(quotient: &mut [N], block: &[N], pivot: &[N], rows: usize, n: usize);
    /// x ← D⁻¹ x.
    fn solve(pivot: &[N], x: &mut [N], n: usize);
}

/// The inverse itself; what is not positive definite is refused. The quicker one where blocks are well conditioned.
#[derive(Clone, Debug, Default)]
pub(crate) struct Inverse;

impl Pivot<f64> for Inverse {
    const IS_FUSED: bool = true;

    #[inline(always)]
    fn factor(block: &mut [f64], n: usize) -> bool {
        with_rows!(n, R => {
            let [columns] = block.as_chunks_mut::<R>().0.as_chunks_mut::<R>().0 else { return false };
            invert(columns, |pivot, _| pivot > 0.0)
        })
    }

    #[inline(always)]
    fn divide(quotient: &mut [f64], block: &[f64], pivot: &[f64], rows: usize, n: usize) {
        for column in 0..n {
            let sums = &mut quotient[column * rows..(column + 1) * rows];
            sums.fill(0.0);
            for inner in 0..n {
                let factor = pivot[column * n + inner];
                for (sum, value) in sums.iter_mut().zip(&block[inner * rows..(inner + 1) * rows]) {
                    *sum = value.mul_add(factor, *sum);
                }
            }
        }
    }

    #[inline(always)]
    fn solve(pivot: &[f64], x: &mut [f64], n: usize) {
        let mut sums = [0.0; super::layout::MOST_ROWS];
        for (column, factor) in x.iter().enumerate() {
            for (sum, value) in sums.iter_mut().zip(&pivot[column * n..(column + 1) * n]) {
                *sum += value * factor;
            }
        }
        x.copy_from_slice(&sums[..n]);
    }
}

/// Inverts a matrix where it stands by Gauss and Jordan's elimination, without exchanging rows. `is_good` is asked of each
/// pivot, with the pivot and what is below it in its column, whether to go on; where it is not, the matrix is spoilt, and
/// the answer false.
#[inline(always)]
pub(super) fn invert<const R: usize>(columns: &mut [[f64; R]; R], is_good: impl Fn(f64, &[f64]) -> bool) -> bool {
    let mut now = *columns;
    let is_inverted = eliminate::<R, 0>(&mut now, &is_good)
        && eliminate::<R, 1>(&mut now, &is_good)
        && eliminate::<R, 2>(&mut now, &is_good)
        && eliminate::<R, 3>(&mut now, &is_good)
        && eliminate::<R, 4>(&mut now, &is_good)
        && eliminate::<R, 5>(&mut now, &is_good);
    *columns = now;
    is_inverted
}

/// Eliminates by one pivot, if there are so many rows. The compiler knows which: with an index that it does not know, all
/// numbers are written to memory and read again for each pivot, which takes several times as long.
#[inline(always)]
fn eliminate<const R: usize, const PIVOT: usize>(
    columns: &mut [[f64; R]; R],
    is_good: impl Fn(f64, &[f64]) -> bool,
) -> bool {
    if PIVOT >= R {
        return true;
    }
    let mut others = columns[PIVOT];
    let pivot = others[PIVOT];
    let goes_on = is_good(pivot, &others[PIVOT..]);
    let inverse = 1.0 / pivot;
    others[PIVOT] = 0.0;
    columns[PIVOT] = [0.0; R];
    columns[PIVOT][PIVOT] = 1.0;
    for column in columns {
        let share = column[PIVOT] * inverse;
        for (value, other) in column.iter_mut().zip(&others) {
            *value = other.mul_add(-share, *value);
        }
        column[PIVOT] = share;
    }
    goes_on
}

/// LDLᵀ within the block: L below the diagonal, D⁻¹ on it, zero where a pivot is not positive. Where the pivots of one
/// direction are tiny, as near singular poses, the inverse would spoil all others.
#[derive(Clone, Debug, Default)]
pub(crate) struct Triangular;

impl<N: Number> Pivot<N> for Triangular {
    const IS_FUSED: bool = false;

    #[inline(always)]
    fn factor(block: &mut [N], n: usize) -> bool {
        with_rows!(n, R => {
            let block = &mut block[..R * R];
            for pivot in 0..R {
                let square = block[pivot * R + pivot];
                let inverse = (N::one() / square).select(square.simd_gt(N::zero()), N::zero());
                block[pivot * R + pivot] = inverse;
                // The upper triangle keeps the row before it is divided.
                for row in pivot + 1..R {
                    block[row * R + pivot] = block[pivot * R + row];
                    block[pivot * R + row] *= inverse;
                }
                for column in pivot + 1..R {
                    for row in column..R {
                        let product = block[pivot * R + row] * block[column * R + pivot];
                        block[column * R + row] -= product;
                    }
                }
            }
        });
        true
    }

    #[inline(always)]
    fn divide(quotient: &mut [N], _: &[N], pivot: &[N], rows: usize, n: usize) {
        // All rows at once: they lie side by side.
        with_rows!(rows, R => {
            let columns = quotient.as_chunks_mut::<R>().0;
            for column in 1..n {
                let (done, left) = columns.split_at_mut(column);
                for (before, done) in done.iter().enumerate() {
                    subtract_share(&mut left[0], pivot[before * n + column], done);
                }
            }
            for column in (0..n).rev() {
                let (own, done) = columns[column..n].split_at_mut(1);
                own[0].iter_mut().for_each(|value| *value *= pivot[column * n + column]);
                for (after, done) in (column + 1..n).zip(done) {
                    subtract_share(&mut own[0], pivot[column * n + after], done);
                }
            }
        });
    }

    #[inline(always)]
    fn solve(pivot: &[N], x: &mut [N], n: usize) {
        Self::divide(x, &[], pivot, 1, n);
    }
}

/// y −= share x.
#[inline(always)]
fn subtract_share<N: Number, const R: usize>(y: &mut [N; R], share: N, x: &[N; R]) {
    for (y, &x) in y.iter_mut().zip(x) {
        *y -= share * x;
    }
}
