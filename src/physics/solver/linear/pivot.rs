//! How blocks on the diagonal are inverted, and what is done where they have no inverse.
//!
//! Blocks are slices, columns one after the other.

use super::layout::Number;

/// What an expression is with the rows of a block, 1 to 6, as a constant: compiled once for each. With a number that is not
/// known when compiling, numbers that lie side by side are taken one at a time, or by masks, which wait for each other.
macro_rules! with_rows {
    ($rows:expr, $constant:ident => $what:expr) => {
        match $rows {
            1 => with_rows!(@ 1, $constant => $what),
            2 => with_rows!(@ 2, $constant => $what),
            3 => with_rows!(@ 3, $constant => $what),
            4 => with_rows!(@ 4, $constant => $what),
            5 => with_rows!(@ 5, $constant => $what),
            6 => with_rows!(@ 6, $constant => $what),
            _ => unreachable!("blocks have 1 to 6 rows"),
        }
    };
    (@ $rows:literal, $constant:ident => $what:expr) => {{
        const $constant: usize = $rows;
        $what
    }};
}
pub(super) use with_rows;

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
        // The size of nearly all blocks that are inverted.
        if n == 6
            && let Some(columns) = block.as_chunks_mut::<6>().0.as_chunks_mut::<6>().0.first_mut()
        {
            return invert(columns, |pivot, _| pivot > 0.0);
        }
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

/// Inverts a matrix where it stands by Gauss and Jordan's elimination, without exchanging rows. `is_good` is asked of each
/// pivot, with the pivot and what is below it in its column, whether to go on; where it is not, the matrix is spoilt, and
/// the answer false.
#[inline(always)]
pub(super) fn invert(columns: &mut [[f64; 6]; 6], is_good: impl Fn(f64, &[f64]) -> bool) -> bool {
    let mut now = *columns;
    let is_inverted = eliminate::<0>(&mut now, &is_good)
        && eliminate::<1>(&mut now, &is_good)
        && eliminate::<2>(&mut now, &is_good)
        && eliminate::<3>(&mut now, &is_good)
        && eliminate::<4>(&mut now, &is_good)
        && eliminate::<5>(&mut now, &is_good);
    *columns = now;
    is_inverted
}

/// Eliminates by one pivot. The compiler knows which: with an index that it does not know, all numbers are written to memory
/// and read again for each pivot, which takes several times as long.
#[inline(always)]
fn eliminate<const PIVOT: usize>(columns: &mut [[f64; 6]; 6], is_good: impl Fn(f64, &[f64]) -> bool) -> bool {
    let mut others = columns[PIVOT];
    let pivot = others[PIVOT];
    let goes_on = is_good(pivot, &others[PIVOT..]);
    let inverse = 1.0 / pivot;
    others[PIVOT] = 0.0;
    columns[PIVOT] = [0.0; 6];
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
