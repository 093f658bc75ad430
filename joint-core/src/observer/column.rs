//! What one standard deviation of an innovation makes of every quantity that is corrected.

use crate::scalar::Scalar;

/// The measured channels: current, rotor angle, output angle.
pub const CHANNELS: usize = 3;

/// One value for every quantity that the observer corrects. Bristles are not among them: what a
/// sensor says of them is lost in what it says of the speeds that drive them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = "G: crate::number::Wire"))]
pub struct Column<G, const N: usize> {
    /// Current, A.
    pub current: G,
    /// Rotor angle, rad.
    pub angle: G,
    /// Rotor speed, rad/s.
    pub speed: G,
    /// The stages, reflected to the motor.
    #[cfg_attr(feature = "serde", serde(with = "serde_big_array::BigArray"))]
    pub stages: [StageRow<G>; N],
    /// Load torque at the output, Nm.
    pub load: G,
    /// Its change in a step, Nm.
    pub slope: G,
    /// Drive beside the applied one, V (A where the current is imposed).
    pub bias: G,
}

impl<G: Copy, const N: usize> Column<G, N> {
    /// The same value for everything.
    pub fn filled(value: G) -> Self {
        let row = StageRow { deflection: value, speed: value };
        Self {
            current: value,
            angle: value,
            speed: value,
            stages: [row; N],
            load: value,
            slope: value,
            bias: value,
        }
    }
}

/// One value for every quantity of a stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = "G: crate::number::Wire"))]
pub struct StageRow<G> {
    /// Deflection of its spring, rad.
    pub deflection: G,
    /// Speed of the mass behind it, rad/s.
    pub speed: G,
}

/// Constants of the sums over all channels, one for every quantity.
pub(super) fn summed<S: Scalar, const N: usize>(
    [a, b, c]: &[Column<f64, N>; CHANNELS],
) -> [Column<S::Gain, N>; CHANNELS] {
    let mut own = [Column::filled(S::Gain::default()); CHANNELS];
    let [x, y, z] = &mut own;
    [x.current, y.current, z.current] = S::gains([a.current, b.current, c.current]);
    [x.angle, y.angle, z.angle] = S::gains([a.angle, b.angle, c.angle]);
    [x.speed, y.speed, z.speed] = S::gains([a.speed, b.speed, c.speed]);
    let from = a.stages.iter().zip(&b.stages).zip(&c.stages);
    let to = x.stages.iter_mut().zip(&mut y.stages).zip(&mut z.stages);
    for (((a, b), c), ((x, y), z)) in from.zip(to) {
        [x.deflection, y.deflection, z.deflection] =
            S::gains([a.deflection, b.deflection, c.deflection]);
        [x.speed, y.speed, z.speed] = S::gains([a.speed, b.speed, c.speed]);
    }
    [x.load, y.load, z.load] = S::gains([a.load, b.load, c.load]);
    [x.slope, y.slope, z.slope] = S::gains([a.slope, b.slope, c.slope]);
    [x.bias, y.bias, z.bias] = S::gains([a.bias, b.bias, c.bias]);
    own
}
