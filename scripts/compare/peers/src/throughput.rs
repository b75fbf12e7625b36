//! The throughput of a single ray: one number, or a Stokes row with its frame.

use spectral_core::{
    fresnel::Fresnel,
    stokes::{Scalar, StokesRow, align, any_axis},
};

pub trait Throughput: Copy {
    fn eye(direction: [f32; 3]) -> Self;
    fn intensity(&self) -> f32;
    /// The reflected and the refracted throughput.
    fn children(self, direction: [f32; 3], normal: [f32; 3], event: &Fresnel<f32>) -> [Self; 2];
}

impl Throughput for Scalar<f32> {
    fn eye(_direction: [f32; 3]) -> Self {
        Scalar::eye()
    }

    fn intensity(&self) -> f32 {
        self.0
    }

    #[inline(always)]
    fn children(self, _direction: [f32; 3], _normal: [f32; 3], event: &Fresnel<f32>) -> [Self; 2] {
        [self.reflected(event), self.refracted(event)]
    }
}

#[derive(Clone, Copy)]
pub struct Polarized {
    row: StokesRow<f32>,
    axis: [f32; 3],
}

impl Throughput for Polarized {
    fn eye(direction: [f32; 3]) -> Self {
        Polarized { row: StokesRow::eye(), axis: any_axis(direction) }
    }

    fn intensity(&self) -> f32 {
        self.row.intensity()
    }

    #[inline(always)]
    fn children(self, direction: [f32; 3], normal: [f32; 3], event: &Fresnel<f32>) -> [Self; 2] {
        let frame = align(direction, self.axis, normal);
        let row = self.row.rotated(frame.cos2, frame.sin2);
        let axis = frame.axis;
        [Polarized { row: row.reflected(event), axis }, Polarized { row: row.refracted(event), axis }]
    }
}
