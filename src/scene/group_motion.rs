//! Mass, motion and shape of a group of atoms (LAMMPS doc page `variable`, group functions).
//! Sums run in storage order and each term is formed in LAMMPS's order, so that results agree to the last bit.

use nalgebra::Matrix3;

use crate::system::temperature::sum_mass_velocity_squared;
use crate::system::{SimulationBox, State, Vec3};

/// Determinant of the inertia tensor below which it counts as singular, and the ratio of moments that count as zero.
const SINGULAR: f64 = 1.0e-6;

/// The atoms of the groups in `mask`.
#[derive(Clone, Copy, Debug)]
pub struct Members<'a> {
    pub state: &'a State,
    /// Indexed by type - 1.
    pub masses: &'a [f64],
    pub mask: u32,
    pub simulation_box: &'a SimulationBox,
}

impl Members<'_> {
    /// Storage indices of the atoms.
    pub fn indices(&self) -> impl Iterator<Item = usize> {
        let mask = self.mask;
        self.state.mask.iter().enumerate().filter(move |(_, m)| **m & mask != 0).map(|(k, _)| k)
    }

    pub fn count(&self) -> usize {
        self.indices().count()
    }

    fn mass_of(&self, k: usize) -> f64 {
        self.masses[self.state.kind[k] as usize - 1]
    }

    fn unwrapped(&self, k: usize) -> Vec3 {
        self.simulation_box.unwrap(&self.state.x[k], &self.state.image[k])
    }

    pub fn mass(&self) -> f64 {
        self.indices().fold(0.0, |sum, k| sum + self.mass_of(k))
    }

    /// Mass-weighted mean of a per-atom vector; zero without mass.
    fn weighted_mean(&self, total: f64, vector: impl Fn(usize) -> Vec3) -> Vec3 {
        let sum = self.indices().fold(Vec3::zeros(), |sum, k| sum + vector(k) * self.mass_of(k));
        if total > 0.0 { sum / total } else { sum }
    }

    /// Center of mass of the unwrapped positions.
    pub fn center(&self) -> Vec3 {
        self.weighted_mean(self.mass(), |k| self.unwrapped(k))
    }

    /// Velocity of the center of mass.
    pub fn velocity(&self) -> Vec3 {
        self.weighted_mean(self.mass(), |k| self.state.v[k])
    }

    /// Total force.
    pub fn force(&self) -> Vec3 {
        self.indices().fold(Vec3::zeros(), |sum, k| sum + self.state.f[k])
    }

    /// Sum of m v^2.
    pub fn sum_mass_velocity_squared(&self) -> f64 {
        sum_mass_velocity_squared(self.state, self.masses, self.mask)
    }

    /// Lowest and highest coordinates; +-1e20 without atoms, as LAMMPS has it.
    pub fn bounds(&self) -> [Vec3; 2] {
        let start = [Vec3::repeat(1.0e20), Vec3::repeat(-1.0e20)];
        self.indices().fold(start, |[lo, hi], k| [lo.inf(&self.state.x[k]), hi.sup(&self.state.x[k])])
    }

    /// Radius of gyration about the center of mass.
    pub fn gyration(&self) -> f64 {
        let (total, center) = (self.mass(), self.center());
        let sum = self.indices().fold(0.0, |sum, k| {
            let d = self.unwrapped(k) - center;
            sum + (d.x * d.x + d.y * d.y + d.z * d.z) * self.mass_of(k)
        });
        if total > 0.0 { (sum / total).sqrt() } else { 0.0 }
    }

    /// Angular momentum about a point, in mass units.
    pub fn angular_momentum(&self, center: &Vec3) -> Vec3 {
        self.indices().fold(Vec3::zeros(), |sum, k| {
            let (d, v, m) = (self.unwrapped(k) - center, self.state.v[k], self.mass_of(k));
            sum + Vec3::new(m * (d.y * v.z - d.z * v.y), m * (d.z * v.x - d.x * v.z), m * (d.x * v.y - d.y * v.x))
        })
    }

    /// Torque about a point.
    pub fn torque(&self, center: &Vec3) -> Vec3 {
        self.indices().fold(Vec3::zeros(), |sum, k| sum + (self.unwrapped(k) - center).cross(&self.state.f[k]))
    }

    /// Inertia tensor about a point.
    pub fn inertia(&self, center: &Vec3) -> Matrix3<f64> {
        let mut tensor = Matrix3::zeros();
        for k in self.indices() {
            let (d, m) = (self.unwrapped(k) - center, self.mass_of(k));
            tensor[(0, 0)] += m * (d.y * d.y + d.z * d.z);
            tensor[(1, 1)] += m * (d.x * d.x + d.z * d.z);
            tensor[(2, 2)] += m * (d.x * d.x + d.y * d.y);
            tensor[(0, 1)] -= m * d.x * d.y;
            tensor[(1, 2)] -= m * d.y * d.z;
            tensor[(0, 2)] -= m * d.x * d.z;
        }
        tensor.fill_lower_triangle_with_upper_triangle();
        tensor
    }
}

/// The angular velocity that goes with an angular momentum: L = I omega.
/// Along axes with no moment of inertia (two atoms, a line of atoms) it is zero.
pub fn angular_velocity(momentum: &Vec3, inertia: &Matrix3<f64>) -> Vec3 {
    let i = |r: usize, c: usize| inertia[(r, c)];
    let determinant = i(0, 0) * i(1, 1) * i(2, 2) + i(0, 1) * i(1, 2) * i(2, 0) + i(0, 2) * i(1, 0) * i(2, 1)
        - i(0, 0) * i(1, 2) * i(2, 1)
        - i(0, 1) * i(1, 0) * i(2, 2)
        - i(2, 0) * i(1, 1) * i(0, 2);
    if determinant > SINGULAR {
        // Rows of the inverse by cofactors.
        let row = |a: [f64; 3]| {
            let [x, y, z] = a.map(|cofactor| cofactor / determinant);
            x * momentum.x + y * momentum.y + z * momentum.z
        };
        return Vec3::new(
            row([
                i(1, 1) * i(2, 2) - i(1, 2) * i(2, 1),
                -(i(0, 1) * i(2, 2) - i(0, 2) * i(2, 1)),
                i(0, 1) * i(1, 2) - i(0, 2) * i(1, 1),
            ]),
            row([
                -(i(1, 0) * i(2, 2) - i(1, 2) * i(2, 0)),
                i(0, 0) * i(2, 2) - i(0, 2) * i(2, 0),
                -(i(0, 0) * i(1, 2) - i(0, 2) * i(1, 0)),
            ]),
            row([
                i(1, 0) * i(2, 1) - i(1, 1) * i(2, 0),
                -(i(0, 0) * i(2, 1) - i(0, 1) * i(2, 0)),
                i(0, 0) * i(1, 1) - i(0, 1) * i(1, 0),
            ]),
        );
    }
    let (moments, axes) = principal_axes(inertia);
    let largest = moments.into_iter().fold(0.0, f64::max);
    let mut order = [0, 1, 2];
    order.sort_by(|a: &usize, b: &usize| moments[*b].total_cmp(&moments[*a]));
    let mut omega = Vec3::zeros();
    for (moment, axis) in order.map(|k| (moments[k], axes[k])) {
        if moment >= SINGULAR * largest && moment > 0.0 {
            let along = (momentum.x * axis.x + momentum.y * axis.y + momentum.z * axis.z) / moment;
            omega += along * axis;
        }
    }
    omega
}

/// Eigenvalues and unit eigenvectors of a symmetric matrix by Jacobi's method: the largest off-diagonal element is rotated away
/// until none matters (Golub and Van Loan, Matrix Computations, section 8.5).
fn principal_axes(matrix: &Matrix3<f64>) -> ([f64; 3], [Vec3; 3]) {
    /// Far more rotations than three dimensions ever need.
    const MAX_ROTATIONS: usize = 150;
    let mut m = *matrix;
    let mut axes = [Vec3::x(), Vec3::y(), Vec3::z()];
    for _ in 0..MAX_ROTATIONS {
        let (mut i, mut j, mut k) = (0, 1, 2);
        for (p, q, r) in [(0, 2, 1), (1, 2, 0)] {
            if m[(p, q)].abs() > m[(i, j)].abs() {
                (i, j, k) = (p, q, r);
            }
        }
        let pivot = m[(i, j)];
        if m[(i, i)] + pivot == m[(i, i)] && m[(j, j)] + pivot == m[(j, j)] {
            break;
        }
        // Tangent, cosine and sine of the smaller of the two angles that make the pivot vanish.
        let difference = m[(j, j)] - m[(i, i)];
        let t = if difference == 0.0 {
            1.0
        } else {
            let cotangent = difference / (2.0 * pivot);
            (1.0 / ((1.0 + cotangent * cotangent).sqrt() + cotangent.abs())).copysign(cotangent)
        };
        let c = 1.0 / (1.0 + t * t).sqrt();
        let s = c * t;
        m[(i, i)] -= t * pivot;
        m[(j, j)] += t * pivot;
        let (ik, jk) = (m[(i, k)], m[(j, k)]);
        for (place, value) in [((i, j), 0.0), ((i, k), c * ik - s * jk), ((j, k), s * ik + c * jk)] {
            m[place] = value;
            m[(place.1, place.0)] = value;
        }
        (axes[i], axes[j]) = (c * axes[i] - s * axes[j], s * axes[i] + c * axes[j]);
    }
    ([m[(0, 0)], m[(1, 1)], m[(2, 2)]], axes)
}
