//! What a path carries from event to event: a Stokes row with its frame, or one number.

use spectral_core::{
    Real,
    fresnel::Fresnel,
    stokes::{Scalar, StokesRow, align, any_axis},
};

/// The throughput of one wavelength along a path.
pub(crate) trait Throughput<T: Real>: Copy + Send + 'static {
    /// What leaves the eye along a unit direction.
    fn eye(direction: [T; 3]) -> Self;
    /// What arrives of unpolarised light of intensity 1.
    fn intensity(&self) -> T;
    /// Times `factor`.
    fn scaled(self, factor: T) -> Self;
    /// After a surface with unit `normal` (either way round) met along unit `direction`: the reflected and
    /// the refracted share.
    fn split(self, direction: [T; 3], normal: [T; 3], event: &Fresnel<T>) -> [Self; 2];
}

impl<T: Real> Throughput<T> for Scalar<T> {
    #[inline]
    fn eye(_direction: [T; 3]) -> Self {
        Scalar::eye()
    }

    #[inline]
    fn intensity(&self) -> T {
        self.0
    }

    #[inline]
    fn scaled(self, factor: T) -> Self {
        Scalar::scaled(self, factor)
    }

    #[inline]
    fn split(self, _direction: [T; 3], _normal: [T; 3], event: &Fresnel<T>) -> [Self; 2] {
        [self.reflected(event), self.refracted(event)]
    }
}

/// A Stokes row and the first axis of its frame, perpendicular to the ray.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Polarized<T> {
    row: StokesRow<T>,
    axis: [T; 3],
}

impl<T: Real> Throughput<T> for Polarized<T> {
    #[inline]
    fn eye(direction: [T; 3]) -> Self {
        Polarized { row: StokesRow::eye(), axis: any_axis(direction) }
    }

    #[inline]
    fn intensity(&self) -> T {
        self.row.intensity()
    }

    #[inline]
    fn scaled(self, factor: T) -> Self {
        Polarized { row: self.row.scaled(factor), ..self }
    }

    // Called out of line it passes its arguments through memory, in pieces that stall the loads: a third of
    // the time of a render.
    #[inline(always)]
    fn split(self, direction: [T; 3], normal: [T; 3], event: &Fresnel<T>) -> [Self; 2] {
        let frame = align(direction, self.axis, normal);
        let row = self.row.rotated(frame.cos2, frame.sin2);
        let axis = frame.axis;
        [Polarized { row: row.reflected(event), axis }, Polarized { row: row.refracted(event), axis }]
    }
}
