//! Trees for tests.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::math::Pose;
use crate::math::random::Random;
use crate::physics::body::Symmetry;
use crate::physics::tree::impact::Side;
use crate::physics::tree::{Forest, ForestSnapshot, Joint, JointKind, Link, Tree, TreeState};
use crate::physics::{Body, Drag};

pub const GRAVITY: Vector3<f64> = Vector3::new(0.3, -0.2, -9.81);

/// A rod along its third axis, not quite thin.
pub fn rod(mass_kg: f64, length_m: f64) -> Body {
    let across = mass_kg * length_m * length_m / 12.0;
    Body::new(mass_kg, Vector3::new(across, across, 0.02 * across)).unwrap()
}

pub fn at(z: f64) -> Pose {
    Pose::translation(0.0, 0.0, z)
}

pub const UNIVERSAL: JointKind = JointKind::Universal {
    axes: [Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 1.0, 0.0)],
};

pub const PIN: JointKind = JointKind::Pin {
    axis: Vector3::new(1.0, 0.0, 0.0),
};

/// Rods of 0.3 m and 0.1 kg from end to end; the first one's joint given apart.
pub fn rods(count: usize, first: JointKind, others: JointKind) -> Vec<Link> {
    (0..count)
        .map(|index| Link {
            parent: index.checked_sub(1),
            joint: match index {
                0 => Joint::new(first, Pose::identity(), at(0.15)),
                _ => Joint::new(others, at(-0.15), at(0.15)),
            },
            body: rod(0.1, 0.3),
        })
        .collect()
}

/// Three rods, free, with two universal joints.
pub fn chain() -> Tree {
    Tree::new(&rods(3, JointKind::Free, UNIVERSAL)).unwrap()
}

fn somewhere(random: &mut Random) -> Pose {
    let mut vector = || Vector3::new(random.signed(), random.signed(), random.signed());
    let place = vector() * 0.3;
    Pose::from_parts(
        place.into(),
        UnitQuaternion::from_scaled_axis(vector() * 2.0),
    )
}

/// A branched tree of all kinds of joints with arbitrary frames, dampers and springs.
pub fn bush(is_free: bool) -> Tree {
    Tree::new(&bush_links(is_free)).unwrap()
}

fn bush_links(is_free: bool) -> Vec<Link> {
    let mut random = Random::default();
    let parents = [
        None,
        Some(0),
        Some(1),
        Some(1),
        Some(0),
        Some(4),
        Some(2),
        Some(3),
    ];
    parents
        .iter()
        .enumerate()
        .map(|(index, parent)| {
            let mut vector = || Vector3::new(random.signed(), random.signed(), random.signed());
            let kind = match index {
                0 if is_free => JointKind::Free,
                0 | 3 => JointKind::Ball,
                1 | 6 => JointKind::Universal {
                    axes: [vector(), vector()],
                },
                2 | 4 => JointKind::Pin { axis: vector() },
                5 => JointKind::Fixed,
                _ => JointKind::Ball,
            };
            let mut joint = Joint::new(kind, somewhere(&mut random), somewhere(&mut random));
            if !matches!(kind, JointKind::Free | JointKind::Fixed) {
                joint.damping_n_m_s = 0.01 * (1.0 + random.signed());
                joint.stiffness_n_m = 0.3 * (1.0 + random.signed());
                joint.rest_rad = [0.2, -0.3];
            }
            let spread = [0, 1, 2].map(|_| 1.5 + random.signed());
            let [a, b, c] = spread;
            Link {
                parent: *parent,
                joint,
                body: Body::new(0.3 * a, Vector3::new(b + c, c + a, a + b) * 0.01).unwrap(),
            }
        })
        .collect()
}

/// Trees whose links are pushed by forces, slowed by the air and, where they are balls, lifted by it.
pub fn pushed_trees() -> Vec<(&'static str, Tree)> {
    let of = |mut links: Vec<Link>| {
        for (link, at) in links.iter_mut().zip(1..) {
            link.body = pushed(link.body, f64::from(at));
        }
        Tree::new(&links).unwrap()
    };
    let mut cord = rods(2, JointKind::Ball, UNIVERSAL);
    cord[1].body = ball();
    vec![
        ("chain", of(rods(3, JointKind::Free, UNIVERSAL))),
        ("bush, free", of(bush_links(true))),
        ("bush, clamped", of(bush_links(false))),
        ("ball on a cord", of(cord)),
    ]
}

pub fn ball() -> Body {
    Body::new(0.2, Vector3::repeat(1e-3)).unwrap()
}

/// A body that is pushed, the more the greater this is.
pub fn pushed(body: Body, by: f64) -> Body {
    let drag = Drag {
        linear_per_s: 0.3 * by,
        quadratic_per_m: 0.2 / by,
    };
    let force_m_s2 = Vector3::new(0.5, -0.8 * by, 0.3);
    let pushed = body.with_force(force_m_s2).unwrap();
    let pushed = pushed.with_drag(drag).unwrap();
    match body.symmetry() {
        Symmetry::Spherical => pushed.with_lift(0.05 * by).unwrap(),
        _ => pushed,
    }
}

/// Some state with coordinates and rates of the given sizes.
pub fn some_state(tree: &Tree, random: &mut Random, turned: f64, rate: f64) -> TreeState {
    let freedoms = tree.freedoms();
    let delta: Vec<f64> = (0..2 * freedoms)
        .map(|i| random.signed() * if i < freedoms { turned } else { rate })
        .collect();
    tree.retract(&tree.at_rest(), &delta)
}

/// What an impulse at a point of a link does to the point's own velocity [1/kg].
pub fn inverse_mass_at(
    tree: &Tree,
    state: &TreeState,
    (place, point_m): (usize, &Vector3<f64>),
) -> Matrix3<f64> {
    let forest = Forest::new(vec![tree.clone()]);
    let mut snapshot = ForestSnapshot::new(&forest, &GRAVITY);
    snapshot.set(state);
    let side = Side {
        place,
        sign: 1.0,
        point_m: *point_m,
    };
    let (jacobian, response) = snapshot.response(&[&[side]]);
    let product = jacobian * response;
    product.fixed_view::<3, 3>(0, 0).into_owned()
}

/// All trees of the tests with names.
pub fn trees() -> Vec<(&'static str, Tree)> {
    let of = |count, first, others| Tree::new(&rods(count, first, others)).unwrap();
    vec![
        ("chain", chain()),
        ("bush, free", bush(true)),
        ("bush, clamped", bush(false)),
        ("two pins", of(2, PIN, PIN)),
        ("three universal", of(3, UNIVERSAL, UNIVERSAL)),
        ("two balls", of(2, JointKind::Ball, JointKind::Ball)),
        ("free, balls", of(4, JointKind::Free, JointKind::Ball)),
    ]
}

/// Greatest difference of a derivative from differences of `f` at zero, relative to its greatest
/// entry. Each entry is compared at three lengths of steps, of which the best counts: entries bend and
/// round differently.
pub fn off(exact: &nalgebra::DMatrix<f64>, f: impl Fn(&[f64]) -> Vec<f64>) -> f64 {
    let (rows, columns) = exact.shape();
    let numeric = [0.4, 0.1, 0.03].map(|scale| {
        let table = crate::math::differentiate::jacobian(rows, columns, |delta| {
            let scaled: Vec<f64> = delta.iter().map(|x| scale * x).collect();
            f(&scaled)
        });
        (scale, table)
    });
    let mut worst = 0.0_f64;
    for row in 0..rows {
        for column in 0..columns {
            let best = numeric
                .iter()
                .map(|(scale, table)| (table[row][column] / scale - exact[(row, column)]).abs())
                .fold(f64::INFINITY, f64::min);
            worst = worst.max(best);
        }
    }
    worst / exact.amax()
}
