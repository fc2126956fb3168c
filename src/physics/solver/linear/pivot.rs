//! How blocks on the diagonal are inverted, and what is done where they have no inverse.
//!
//! Blocks are slices, columns one after the other.

use super::layout::Number;

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

    /// Sweeps the pivots one by one (Goodnight 1979).
    #[inline(always)]
    fn factor(block: &mut [f64], n: usize) -> bool {
        for pivot in 0..n {
            let square = block[pivot * n + pivot];
            if square.is_nan() || square <= 0.0 {
                return false;
            }
            let inverse = 1.0 / square;
            for other in (0..n).filter(|&other| other != pivot) {
                let share = block[other * n + pivot] * inverse;
                for row in 0..n {
                    block[other * n + row] = block[pivot * n + row].mul_add(-share, block[other * n + row]);
                }
                block[other * n + pivot] = share;
            }
            for row in 0..n {
                block[pivot * n + row] *= -inverse;
            }
            block[pivot * n + pivot] = inverse;
        }
        true
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

/// LDLᵀ within the block: L below the diagonal, D⁻¹ on it, zero where a pivot is not positive. Where the pivots of one
/// direction are tiny, as near singular poses, the inverse would spoil all others.
#[derive(Clone, Debug, Default)]
pub(crate) struct Triangular;

impl<N: Number> Pivot<N> for Triangular {
    const IS_FUSED: bool = false;

    #[inline(always)]
    fn factor(block: &mut [N], n: usize) -> bool {
        for pivot in 0..n {
            let square = block[pivot * n + pivot];
            let inverse = (N::one() / square).select(square.simd_gt(N::zero()), N::zero());
            block[pivot * n + pivot] = inverse;
            // The upper triangle keeps the row before it is divided.
            for row in pivot + 1..n {
                block[row * n + pivot] = block[pivot * n + row];
                block[pivot * n + row] *= inverse;
            }
            for column in pivot + 1..n {
                for row in column..n {
                    let product = block[pivot * n + row] * block[column * n + pivot];
                    block[column * n + row] -= product;
                }
            }
        }
        true
    }

    #[inline(always)]
    fn divide(quotient: &mut [N], _: &[N], pivot: &[N], rows: usize, n: usize) {
        // All rows at once: they lie side by side.
        for column in 1..n {
            let (done, left) = quotient.split_at_mut(column * rows);
            for (before, done) in done.chunks_exact(rows).enumerate() {
                subtract_share(&mut left[..rows], pivot[before * n + column], done);
            }
        }
        for column in (0..n).rev() {
            let (own, done) = quotient[column * rows..].split_at_mut(rows);
            own.iter_mut().for_each(|value| *value *= pivot[column * n + column]);
            for (after, done) in (column + 1..n).zip(done.chunks_exact(rows)) {
                subtract_share(own, pivot[column * n + after], done);
            }
        }
    }

    #[inline(always)]
    fn solve(pivot: &[N], x: &mut [N], n: usize) {
        Self::divide(x, &[], pivot, 1, n);
    }
}

/// y −= share x.
#[inline(always)]
fn subtract_share<N: Number>(y: &mut [N], share: N, x: &[N]) {
    for (y, &x) in y.iter_mut().zip(x) {
        *y -= share * x;
    }
}
