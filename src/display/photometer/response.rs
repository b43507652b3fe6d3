//! The fitted light of one channel, whichever the model.

use super::{
    bend::{self, Bend, POINTS},
    shape::Curve,
};
use crate::light::{Transfer, TransferError, TransferTable};

/// Luminance as a function of the encoded value, and back.
#[derive(Clone, Debug, PartialEq)]
pub enum Response {
    /// A curve of a family.
    Curve(Curve),
    /// A table.
    Table {
        /// At V = 0, cd/m².
        black_cd_m2: f64,
        /// Added by V = 1, cd/m².
        range_cd_m2: f64,
        /// Between them.
        transfer: Transfer,
    },
}

impl Response {
    /// A curve, bent, as a table.
    ///
    /// # Errors
    /// When the curve is no display's.
    pub(super) fn bent(curve: &Curve, bend: &Bend) -> Result<Self, TransferError> {
        let (light, top) = bend::table(curve.shape, bend);
        let encoded = (0..POINTS).map(|i| i as f64 / (POINTS - 1) as f64).collect();
        let transfer = Transfer::Table(TransferTable::new(encoded, light)?);
        Ok(Self::Table { black_cd_m2: curve.black_cd_m2, range_cd_m2: curve.range_cd_m2 * top, transfer })
    }

    /// At V = 0, cd/m².
    #[must_use]
    pub fn black_cd_m2(&self) -> f64 {
        match self {
            Self::Curve(curve) => curve.black_cd_m2,
            Self::Table { black_cd_m2, .. } => *black_cd_m2,
        }
    }

    /// Added to black by V = 1, cd/m².
    #[must_use]
    pub fn range_cd_m2(&self) -> f64 {
        match self {
            Self::Curve(curve) => curve.range_cd_m2,
            Self::Table { range_cd_m2, .. } => *range_cd_m2,
        }
    }

    /// Luminance of the encoded value `v`, 0…1, cd/m².
    #[must_use]
    pub fn cd_m2(&self, v: f64) -> f64 {
        match self {
            Self::Curve(curve) => curve.cd_m2(v),
            Self::Table { black_cd_m2, range_cd_m2, transfer } => {
                black_cd_m2 + range_cd_m2 * transfer.linear_from_encoded(v)
            }
        }
    }

    /// The encoded value that gives a luminance. 0 for black and less. Above white, what the curve goes on to; a table
    /// goes on straight.
    #[must_use]
    pub fn encoded(&self, cd_m2: f64) -> f64 {
        match self {
            Self::Curve(curve) => curve.encoded(cd_m2),
            Self::Table { black_cd_m2, range_cd_m2, transfer } => {
                let light = (cd_m2 - black_cd_m2) / range_cd_m2;
                let last = 1.0 - transfer.linear_from_encoded(1.0 - 1.0 / 255.0);
                if light > 1.0 { 1.0 + (light - 1.0) / last / 255.0 } else { transfer.encoded_from_linear(light) }
            }
        }
    }

    /// As a transfer function, 0…1 both ways.
    ///
    /// # Errors
    /// When the curve is no display's.
    pub fn transfer(&self) -> Result<Transfer, TransferError> {
        match self {
            Self::Curve(curve) => curve.shape.transfer(),
            Self::Table { transfer, .. } => Ok(transfer.clone()),
        }
    }
}
