//! Robots as lists of parts: their URDF text, and their kinematics and energy by products of matrices, written
//! from the definition of URDF alone.

use nalgebra::{Matrix3, Matrix4, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A link and how it hangs from an earlier one.
#[derive(Clone, Debug)]
pub struct Part {
    pub name: String,
    pub inertial: Option<Inertial>,
    /// More elements of the link.
    pub more: String,
    pub hung: Option<Hung>,
}

#[derive(Clone, Copy, Debug)]
pub struct Inertial {
    pub mass_kg: f64,
    pub origin: Origin,
    /// xx, xy, xz, yy, yz, zz [kg m²].
    pub tensor: [f64; 6],
}

/// Place \[m\] and turn about fixed x, then y, then z \[rad\].
#[derive(Clone, Copy, Debug, Default)]
pub struct Origin {
    pub xyz: [f64; 3],
    pub rpy: [f64; 3],
}

#[derive(Clone, Debug)]
pub struct Hung {
    pub joint: String,
    pub parent: usize,
    pub origin: Origin,
    pub kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    Fixed,
    Floating,
    Turns { axis: [f64; 3] },
}

pub fn part(name: &str, inertial: Option<Inertial>) -> Part {
    Part {
        name: name.into(),
        inertial,
        more: String::new(),
        hung: None,
    }
}

impl Part {
    /// Hangs it from an earlier part; the joint is `to <name>`.
    pub fn on(mut self, parent: usize, origin: Origin, kind: Kind) -> Self {
        self.hung = Some(Hung {
            joint: format!("to_{}", self.name),
            parent,
            origin,
            kind,
        });
        self
    }
}

fn list(numbers: &[f64]) -> String {
    let numbers: Vec<String> = numbers.iter().map(|of| format!("{of:?}")).collect();
    numbers.join(" ")
}

impl Origin {
    fn urdf(&self) -> String {
        format!(
            "<origin xyz=\"{}\" rpy=\"{}\"/>",
            list(&self.xyz),
            list(&self.rpy)
        )
    }

    fn matrix(&self) -> Matrix4<f64> {
        let [roll, pitch, yaw] = self.rpy;
        let turn =
            about(&Vector3::z(), yaw) * about(&Vector3::y(), pitch) * about(&Vector3::x(), roll);
        pose(&turn, &Vector3::from(self.xyz))
    }
}

fn pose(turn: &Matrix3<f64>, at: &Vector3<f64>) -> Matrix4<f64> {
    let mut pose = Matrix4::identity();
    pose.fixed_view_mut::<3, 3>(0, 0).copy_from(turn);
    pose.fixed_view_mut::<3, 1>(0, 3).copy_from(at);
    pose
}

pub fn turn_of(pose: &Matrix4<f64>) -> Matrix3<f64> {
    pose.fixed_view::<3, 3>(0, 0).into_owned()
}

pub fn place_of(pose: &Matrix4<f64>) -> Vector3<f64> {
    pose.fixed_view::<3, 1>(0, 3).into_owned()
}

/// The formula of Rodrigues.
pub fn about(axis: &Vector3<f64>, angle: f64) -> Matrix3<f64> {
    let hat = axis.normalize().cross_matrix();
    Matrix3::identity() + hat * angle.sin() + hat * hat * (1.0 - angle.cos())
}

/// The robot's text.
pub fn urdf(parts: &[Part]) -> String {
    let mut text = String::from("<?xml version=\"1.0\"?>\n<robot name=\"robot\">\n");
    for part in parts {
        text += &format!("  <link name=\"{}\">\n", part.name);
        if let Some(of) = &part.inertial {
            let [xx, xy, xz, yy, yz, zz] = of.tensor;
            text += &format!(
                "    <inertial>{}<mass value=\"{:?}\"/><inertia ixx=\"{xx:?}\" ixy=\"{xy:?}\" ixz=\"{xz:?}\" iyy=\"{yy:?}\" iyz=\"{yz:?}\" izz=\"{zz:?}\"/></inertial>\n",
                of.origin.urdf(),
                of.mass_kg
            );
        }
        text += &part.more;
        text += "  </link>\n";
        let Some(hung) = &part.hung else { continue };
        let (kind, axis) = match hung.kind {
            Kind::Fixed => ("fixed", String::new()),
            Kind::Floating => ("floating", String::new()),
            Kind::Turns { axis } => ("continuous", format!("<axis xyz=\"{}\"/>", list(&axis))),
        };
        text += &format!(
            "  <joint name=\"{}\" type=\"{kind}\">{}<parent link=\"{}\"/><child link=\"{}\"/>{axis}</joint>\n",
            hung.joint,
            hung.origin.urdf(),
            parts[hung.parent].name,
            part.name
        );
    }
    text + "</robot>\n"
}

/// A frame and how it moves, in world axes.
#[derive(Clone, Debug)]
pub struct Moving {
    pub world_from_link: Matrix4<f64>,
    pub velocity: Vector3<f64>,
    pub angular: Vector3<f64>,
}

/// Every link's frame: of angles and rates per part, and of how the base moves.
pub fn kinematics(parts: &[Part], angles: &[f64], rates: &[f64], base: &Moving) -> Vec<Moving> {
    let mut links: Vec<Moving> = Vec::new();
    for (index, part) in parts.iter().enumerate() {
        let still = Moving {
            world_from_link: Matrix4::identity(),
            velocity: Vector3::zeros(),
            angular: Vector3::zeros(),
        };
        let Some(hung) = &part.hung else {
            links.push(if part.name == "world" {
                still
            } else {
                base.clone()
            });
            continue;
        };
        if hung.kind == Kind::Floating {
            links.push(base.clone());
            continue;
        }
        let parent = &links[hung.parent];
        let mut world_from_link = parent.world_from_link * hung.origin.matrix();
        let arm = place_of(&world_from_link) - place_of(&parent.world_from_link);
        let velocity = parent.velocity + parent.angular.cross(&arm);
        let mut angular = parent.angular;
        if let Kind::Turns { axis } = hung.kind {
            let axis = Vector3::from(axis).normalize();
            angular += turn_of(&world_from_link) * axis * rates[index];
            world_from_link *= pose(&about(&axis, angles[index]), &Vector3::zeros());
        }
        links.push(Moving {
            world_from_link,
            velocity,
            angular,
        });
    }
    links
}

/// Kinetic energy \[J\], of links with mass that the world does not hold still.
pub fn energy(parts: &[Part], links: &[Moving]) -> f64 {
    let of = |(part, link): (&Part, &Moving)| {
        let Some(inertial) = &part.inertial else {
            return 0.0;
        };
        let world_from_centre = link.world_from_link * inertial.origin.matrix();
        let arm = place_of(&world_from_centre) - place_of(&link.world_from_link);
        let velocity = link.velocity + link.angular.cross(&arm);
        let [xx, xy, xz, yy, yz, zz] = inertial.tensor;
        let tensor = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let own = turn_of(&world_from_centre).transpose() * link.angular;
        0.5 * inertial.mass_kg * velocity.norm_squared() + 0.5 * own.dot(&(tensor * own))
    };
    parts.iter().zip(links).map(of).sum()
}

pub fn signed(random: &mut ChaCha8Rng, most: f64) -> f64 {
    most * (2.0 * random.random::<f64>() - 1.0)
}

pub fn vector(random: &mut ChaCha8Rng, most: f64) -> [f64; 3] {
    [0; 3].map(|_| signed(random, most))
}

pub fn origin(random: &mut ChaCha8Rng) -> Origin {
    Origin {
        xyz: vector(random, 0.3),
        rpy: vector(random, 3.0),
    }
}

/// Mass and inertia of four points of mass, somewhere, with or without products, some with two equal moments.
pub fn inertial(random: &mut ChaCha8Rng) -> Inertial {
    let points: Vec<[f64; 3]> = (0..3).map(|_| vector(random, 0.1)).collect();
    let mass_kg = 1.0 + signed(random, 0.9);
    let mut second = Matrix3::identity() * 1e-4;
    for at in &points {
        let at = Vector3::from(*at);
        second += at * at.transpose() * mass_kg / 3.0;
    }
    let mut tensor = Matrix3::identity() * second.trace() - second;
    let form = random.random::<f64>();
    if form < 0.3 {
        tensor = Matrix3::from_diagonal(&tensor.symmetric_eigenvalues());
    } else if form < 0.5 {
        // A rod along some direction.
        let along = Vector3::from(points[0]).normalize();
        tensor = (Matrix3::identity() - along * along.transpose() * 0.9) * 0.01 * mass_kg;
    }
    Inertial {
        mass_kg,
        origin: origin(random),
        tensor: [
            tensor[(0, 0)],
            tensor[(0, 1)],
            tensor[(0, 2)],
            tensor[(1, 1)],
            tensor[(1, 2)],
            tensor[(2, 2)],
        ],
    }
}
