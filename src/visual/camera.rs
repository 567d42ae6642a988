//! From where a scene is looked at, and where on a picture a point of it is then.

use nalgebra::Vector3;

/// How far gravity may be off a world axis for directions to be called by axes.
const ALONG: f64 = 0.999;

/// How high a three-quarter view looks down, and how far it is turned from the front view \[rad\].
const THREE_QUARTER_RAD: [f64; 2] = [0.42, 0.65];

/// A direction from which a scene is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum View {
    /// So that the motion is as wide as it may be.
    Front,
    /// A quarter turn about the vertical from the front.
    Side,
    /// From above, its lower edge nearest to the front.
    Top,
    /// From the front, from above and from beside.
    ThreeQuarter,
}

impl View {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::ThreeQuarter, Self::Front, Self::Side, Self::Top];

    /// Its name.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Front => "front",
            Self::Side => "side",
            Self::Top => "top",
            Self::ThreeQuarter => "three-quarter",
        }
    }
}

/// A parallel projection: lengths across the line of sight are the same wherever they are, so that a scale
/// holds for the whole picture. The three directions are unit and right-handed, in world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// To the right of the picture.
    pub right: Vector3<f64>,
    /// To its upper edge.
    pub up: Vector3<f64>,
    /// Out of it, to who looks.
    pub back: Vector3<f64>,
}

impl Camera {
    /// A view of points \[m\], upright against gravity; where there is none z is up. The front is looked at along
    /// that horizontal axis of the world along which the points extend least.
    pub fn new(view: View, gravity_m_s2: &Vector3<f64>, points_m: &[Vector3<f64>]) -> Self {
        let [right, up] = front(gravity_m_s2, points_m);
        let back = right.cross(&up);
        let level = match view {
            View::Front | View::Top => right,
            View::Side => back,
            View::ThreeQuarter => {
                let (sin, cos) = THREE_QUARTER_RAD[1].sin_cos();
                right * cos + back * sin
            }
        };
        let level_back = level.cross(&up);
        let (sin, cos) = match view {
            View::Front | View::Side => (0.0, 1.0),
            View::Top => (1.0, 0.0),
            View::ThreeQuarter => THREE_QUARTER_RAD[0].sin_cos(),
        };
        Self {
            right: level,
            up: up * cos - level_back * sin,
            back: level_back * cos + up * sin,
        }
    }

    /// Where a point of the world is on the picture, to the right and up \[m\].
    pub fn project(&self, point_m: &Vector3<f64>) -> [f64; 2] {
        [point_m.dot(&self.right), point_m.dot(&self.up)]
    }

    /// How near a point is to who looks \[m\].
    pub fn nearness_m(&self, point_m: &Vector3<f64>) -> f64 {
        point_m.dot(&self.back)
    }

    /// The world axes that a direction of the picture is along, as in `+x`; none where it is along none.
    pub fn axis_along(direction: &Vector3<f64>) -> Option<&'static str> {
        let names = [["-x", "+x"], ["-y", "+y"], ["-z", "+z"]];
        let along = (0..3).find(|axis| direction[*axis].abs() > ALONG)?;
        Some(names[along][usize::from(direction[along] > 0.0)])
    }
}

/// To the right and up, seen from the front.
fn front(gravity_m_s2: &Vector3<f64>, points_m: &[Vector3<f64>]) -> [Vector3<f64>; 2] {
    let up = (-gravity_m_s2)
        .try_normalize(1e-6)
        .unwrap_or(Vector3::z_axis().into_inner());
    // The world axes that are most level, made so.
    let mut axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    axes.sort_by(|a, b| a.dot(&up).abs().total_cmp(&b.dot(&up).abs()));
    let first = (axes[0] - up * axes[0].dot(&up)).normalize();
    // Right-handed about up: x and y where z is up.
    let second = up.cross(&first);
    let extent_m = |axis: &Vector3<f64>| {
        let along = points_m.iter().map(|point| point.dot(axis));
        let (least, greatest) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| {
            (a.min(x), b.max(x))
        });
        greatest - least
    };
    // Not so without points either.
    let is_second_wider = extent_m(&second) > 1.2 * extent_m(&first);
    let right = if is_second_wider { second } else { first };
    [right, up]
}

#[cfg(test)]
mod tests {
    use super::*;

    const DOWN: Vector3<f64> = Vector3::new(0.0, 0.0, -9.8);

    fn is_right_handed(camera: &Camera) -> bool {
        let off = camera.right.cross(&camera.up) - camera.back;
        let lengths = [camera.right, camera.up, camera.back].map(|of| (of.norm() - 1.0).abs());
        off.norm() < 1e-12 && lengths.iter().all(|off| *off < 1e-12)
    }

    #[test]
    fn the_front_shows_what_extends_most_and_every_view_is_upright() {
        let wide_m = [Vector3::zeros(), Vector3::new(2.0, 0.5, 1.0)];
        let deep_m = [Vector3::zeros(), Vector3::new(0.5, 2.0, 1.0)];
        for view in View::ALL {
            for points_m in [&wide_m[..], &deep_m, &[]] {
                let camera = Camera::new(view, &DOWN, points_m);
                assert!(is_right_handed(&camera), "{view:?}");
                assert!(camera.up.z > 0.0 || view == View::Top, "{view:?}");
                assert!(camera.back.z > -1e-12, "{view:?}: from below");
            }
        }
        let named = |view, points_m: &[Vector3<f64>]| {
            let of = Camera::new(view, &DOWN, points_m);
            [of.right, of.up].map(|along| Camera::axis_along(&along))
        };
        assert_eq!(named(View::Front, &wide_m), [Some("+x"), Some("+z")]);
        assert_eq!(named(View::Side, &wide_m), [Some("-y"), Some("+z")]);
        assert_eq!(named(View::Top, &wide_m), [Some("+x"), Some("+y")]);
        assert_eq!(named(View::Front, &deep_m), [Some("+y"), Some("+z")]);
        assert_eq!(named(View::ThreeQuarter, &wide_m), [None, None]);
    }

    #[test]
    fn up_is_against_gravity_wherever_that_points() {
        for gravity in [[0.0, -9.8, 0.0], [9.8, 0.0, 0.0], [-3.0, 4.0, -8.0]] {
            let gravity = Vector3::from(gravity);
            let camera = Camera::new(View::Front, &gravity, &[]);
            assert!(is_right_handed(&camera));
            assert!((camera.up + gravity.normalize()).norm() < 1e-12);
        }
        let weightless = Camera::new(View::Front, &Vector3::zeros(), &[]);
        assert_eq!(weightless.up, Vector3::z());
    }

    #[test]
    fn points_are_where_the_axes_say() {
        let camera = Camera::new(View::Top, &DOWN, &[]);
        let point_m = Vector3::new(1.0, 2.0, 3.0);
        let [x_m, y_m] = camera.project(&point_m);
        assert!((x_m - 1.0).abs() < 1e-12 && (y_m - 2.0).abs() < 1e-12);
        assert!((camera.nearness_m(&point_m) - 3.0).abs() < 1e-12);
    }
}
