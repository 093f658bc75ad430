//! Geometry, inertia and stiffness of one stage, and the matrices that follow.

use nalgebra::{DMatrix, DVector, Vector3};

/// Degrees of freedom of a body: x, y, z, then the rotations about them.
pub(super) const PER_BODY: usize = 6;
/// The rotation about the gear's axis.
pub(super) const SPIN: usize = 5;

/// Mass and inertia of one body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Mass, kg.
    pub mass_kg: f64,
    /// Inertia about the gear's axis, kg m².
    pub spin_kg_m2: f64,
    /// Inertia about an axis across it, kg m².
    pub tilt_kg_m2: f64,
}

impl Body {
    /// A solid disc of steel.
    pub fn disc(radius_m: f64, width_m: f64) -> Self {
        let mass_kg = 7800.0 * std::f64::consts::PI * radius_m * radius_m * width_m;
        let spin_kg_m2 = 0.5 * mass_kg * radius_m * radius_m;
        let tilt_kg_m2 = 0.5 * spin_kg_m2 + mass_kg * width_m * width_m / 12.0;
        Self { mass_kg, spin_kg_m2, tilt_kg_m2 }
    }
}

/// Stiffness of a bearing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stiffness {
    /// Across the axis, N/m.
    pub radial_n_per_m: f64,
    /// Along it, N/m.
    pub axial_n_per_m: f64,
    /// Against tilting, Nm/rad.
    pub tilt_nm_per_rad: f64,
}

impl Stiffness {
    fn times(self, factor: f64) -> Self {
        Self {
            radial_n_per_m: factor * self.radial_n_per_m,
            axial_n_per_m: factor * self.axial_n_per_m,
            tilt_nm_per_rad: factor * self.tilt_nm_per_rad,
        }
    }
}

/// A planetary stage: the sun drives, the ring is held, the carrier is driven.
#[derive(Clone, Debug, PartialEq)]
pub struct Gear {
    /// Number of planets, evenly spaced.
    pub planets: usize,
    /// Pitch radius of the sun, m.
    pub sun_radius_m: f64,
    /// Pitch radius of a planet, m.
    pub planet_radius_m: f64,
    /// Face width, m.
    pub width_m: f64,
    /// Transverse pressure angle, rad.
    pub pressure_angle_rad: f64,
    /// Helix angle at the base, rad.
    pub helix_angle_rad: f64,
    /// The sun, with what turns with it.
    pub sun: Body,
    /// The ring.
    pub ring: Body,
    /// The carrier, with what turns with it.
    pub carrier: Body,
    /// A planet.
    pub planet: Body,
    /// Stiffness of a mesh of sun and planet, N/m.
    pub sun_mesh_n_per_m: f64,
    /// Stiffness of a mesh of ring and planet, N/m.
    pub ring_mesh_n_per_m: f64,
    /// Bearings of sun, ring and carrier.
    pub bearing: Stiffness,
    /// Bearing of a planet on its pin.
    pub pin: Stiffness,
    /// What holds the ring against turning, Nm/rad.
    pub ring_hold_nm_per_rad: f64,
}

impl Gear {
    /// A stage of a 6 mm gearhead, 4.25:1 with four planets; assumptions.
    pub fn micro() -> Self {
        let (sun, planet, width) = (0.8e-3, 0.9e-3, 1.2e-3);
        let ring = sun + 2.0 * planet;
        Self {
            planets: 4,
            sun_radius_m: sun,
            planet_radius_m: planet,
            width_m: width,
            pressure_angle_rad: 20.0_f64.to_radians(),
            helix_angle_rad: 10.0_f64.to_radians(),
            sun: Body::disc(sun, width),
            ring: {
                let (outer, inner) = (Body::disc(3e-3, width), Body::disc(ring, width));
                Body {
                    mass_kg: outer.mass_kg - inner.mass_kg,
                    spin_kg_m2: outer.spin_kg_m2 - inner.spin_kg_m2,
                    tilt_kg_m2: outer.tilt_kg_m2 - inner.tilt_kg_m2,
                }
            },
            carrier: Body::disc(2.2e-3, 1e-3),
            planet: Body::disc(planet, width),
            sun_mesh_n_per_m: 1.0e7,
            ring_mesh_n_per_m: 1.2e7,
            bearing: Stiffness { radial_n_per_m: 2e7, axial_n_per_m: 1e7, tilt_nm_per_rad: 20.0 },
            pin: Stiffness { radial_n_per_m: 1.5e7, axial_n_per_m: 1e7, tilt_nm_per_rad: 5.0 },
            ring_hold_nm_per_rad: 1e3,
        }
    }

    /// The same geometry with every stiffness changed by one factor.
    #[must_use]
    pub fn stiffened(mut self, factor: f64) -> Self {
        self.sun_mesh_n_per_m *= factor;
        self.ring_mesh_n_per_m *= factor;
        self.bearing = self.bearing.times(factor);
        self.pin = self.pin.times(factor);
        self.ring_hold_nm_per_rad *= factor;
        self
    }

    /// Turns of the sun over turns of the carrier.
    pub fn ratio(&self) -> f64 {
        2.0 * (self.sun_radius_m + self.planet_radius_m) / self.sun_radius_m
    }

    /// Number of bodies: sun, ring, carrier, planets.
    pub fn bodies(&self) -> usize {
        3 + self.planets
    }

    /// Degrees of freedom.
    pub fn len(&self) -> usize {
        PER_BODY * self.bodies()
    }

    /// Always false.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Masses and inertias in the order of the degrees of freedom.
    pub fn inertia(&self) -> DVector<f64> {
        let planets = std::iter::repeat_n(&self.planet, self.planets);
        let bodies = [&self.sun, &self.ring, &self.carrier].into_iter().chain(planets);
        let rows = bodies.flat_map(|b| {
            [b.mass_kg, b.mass_kg, b.mass_kg, b.tilt_kg_m2, b.tilt_kg_m2, b.spin_kg_m2]
        });
        DVector::from_iterator(self.len(), rows)
    }

    /// The stiffness matrix.
    pub fn stiffness(&self) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(self.len(), self.len());
        self.springs(&mut |stiffness, along| {
            sum.ger(stiffness, along, along, 1.0);
        });
        sum
    }

    /// Every spring with its stiffness and the stretch per unit of each degree of freedom.
    fn springs(&self, each: &mut impl FnMut(f64, &DVector<f64>)) {
        for body in [SUN, RING, CARRIER] {
            self.bearing_of(body, None, Vector3::zeros(), self.bearing, each);
        }
        each(self.ring_hold_nm_per_rad, &self.unit(RING, SPIN));
        let centre_distance = self.sun_radius_m + self.planet_radius_m;
        for k in 0..self.planets {
            let planet = CARRIER + 1 + k;
            let angle = std::f64::consts::TAU * k as f64 / self.planets as f64;
            let outwards = Vector3::new(angle.cos(), angle.sin(), 0.0);
            let around = Vector3::new(-angle.sin(), angle.cos(), 0.0);
            let centre = centre_distance * outwards;
            self.bearing_of(planet, Some(CARRIER), centre, self.pin, each);
            let (sin, cos) = self.pressure_angle_rad.sin_cos();
            let (lift, flat) = self.helix_angle_rad.sin_cos();
            let line =
                |radial: f64| flat * (cos * around + radial * sin * outwards) + lift * Vector3::z();
            let ring_radius = centre_distance + self.planet_radius_m;
            for (body, radius, direction, stiffness) in [
                (SUN, self.sun_radius_m, line(1.0), self.sun_mesh_n_per_m),
                (RING, ring_radius, line(-1.0), self.ring_mesh_n_per_m),
            ] {
                // Two springs give the contact line the tilting stiffness of an even load.
                for end in [-1.0, 1.0] {
                    let along = end * self.width_m / 12.0_f64.sqrt() * Vector3::z();
                    let point = radius * outwards + along;
                    let mut stretch = DVector::zeros(self.len());
                    add(&mut stretch, body, direction, point);
                    add(&mut stretch, planet, -direction, point - centre);
                    each(0.5 * stiffness, &stretch);
                }
            }
        }
    }

    /// A bearing of a body on another at a point, or on the housing.
    fn bearing_of(
        &self,
        body: usize,
        on: Option<usize>,
        at: Vector3<f64>,
        bearing: Stiffness,
        each: &mut impl FnMut(f64, &DVector<f64>),
    ) {
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        let stiffness = [bearing.radial_n_per_m, bearing.radial_n_per_m, bearing.axial_n_per_m];
        for (axis, stiffness) in axes.into_iter().zip(stiffness) {
            let mut stretch = DVector::zeros(self.len());
            add(&mut stretch, body, axis, Vector3::zeros());
            if let Some(on) = on {
                add(&mut stretch, on, -axis, at);
            }
            each(stiffness, &stretch);
        }
        for tilt in [3, 4] {
            let mut stretch = self.unit(body, tilt);
            if let Some(on) = on {
                stretch[PER_BODY * on + tilt] = -1.0;
            }
            each(bearing.tilt_nm_per_rad, &stretch);
        }
    }

    fn unit(&self, body: usize, freedom: usize) -> DVector<f64> {
        let mut unit = DVector::zeros(self.len());
        unit[PER_BODY * body + freedom] = 1.0;
        unit
    }
}

/// Bodies by number; planets follow.
pub(super) const SUN: usize = 0;
/// The ring.
pub(super) const RING: usize = 1;
/// The carrier.
pub(super) const CARRIER: usize = 2;

/// What a body's motion moves a point of it by along a direction: `n·u + (r × n)·θ`.
fn add(stretch: &mut DVector<f64>, body: usize, along: Vector3<f64>, arm: Vector3<f64>) {
    let turning = arm.cross(&along);
    for k in 0..3 {
        stretch[PER_BODY * body + k] += along[k];
        stretch[PER_BODY * body + 3 + k] += turning[k];
    }
}
