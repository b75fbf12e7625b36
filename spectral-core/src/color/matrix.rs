//! 3×3 matrices, row-major: `m[row][column]`, applied to column vectors.

use crate::Real;

/// A 3×3 matrix, row-major.
pub type Matrix = [[f64; 3]; 3];

/// The identity.
pub const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// The scalar product of two vectors.
#[inline]
pub fn dot<T: Real>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// m·v.
pub fn apply(m: &Matrix, v: [f64; 3]) -> [f64; 3] {
    m.map(|row| dot(row, v))
}

/// a·b: the matrix that applies b first.
pub fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let columns = transpose(b);
    a.map(|row| columns.map(|column| dot(row, column)))
}

/// The transpose.
pub fn transpose(m: &Matrix) -> Matrix {
    std::array::from_fn(|row| std::array::from_fn(|column| m[column][row]))
}

/// diag(d)·m: row i times dᵢ.
pub fn scale_rows(d: [f64; 3], m: &Matrix) -> Matrix {
    std::array::from_fn(|row| m[row].map(|x| d[row] * x))
}

/// The inverse, or `None` if the matrix is singular or not finite.
pub fn inverse(m: &Matrix) -> Option<Matrix> {
    let [a, b, c] = *m;
    let cofactors = [cross(b, c), cross(c, a), cross(a, b)];
    let determinant = dot(a, cofactors[0]);
    let inverse = transpose(&cofactors).map(|row| row.map(|x| x / determinant));
    inverse.iter().flatten().all(|x| x.is_finite()).then_some(inverse)
}

/// The vector product of two vectors.
#[inline]
pub fn cross<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_inverse_undoes_its_matrix() {
        let m = [[2.0, 1.0, 0.0], [0.0, 3.0, 1.0], [1.0, 0.0, 4.0]];
        let back = product(&m, &inverse(&m).unwrap());
        for (row, expected) in back.iter().flatten().zip(IDENTITY.iter().flatten()) {
            assert!((row - expected).abs() < 1e-15);
        }
        assert_eq!(inverse(&[[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [0.0, 0.0, 1.0]]), None);
        assert_eq!(apply(&m, [1.0, 10.0, 100.0]), [12.0, 130.0, 401.0]);
    }
}
