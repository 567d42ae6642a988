//! Rows of clearances against differences, and what they hold.

use super::*;
use crate::estimate::posing::clearance::met::given_state;
use crate::estimate::problem::clearance::{ClearSolids, ClearanceTouches, KeptFrom};
use crate::estimate::tree::clearance::{MotionPiece, TreeClearance};
use crate::motion::{Against, LinkIndex};
use crate::physics::State;
use crate::physics::contact::{Contact, Feature, Frame};
use crate::physics::tree::ForestSnapshot;

/// A point of a rod.
const POINT_M: Vector3<f64> = Vector3::new(0.004, 0.003, -0.09);
/// The last rod of the chain, and its first.
const LAST: usize = 2;
const FIRST: usize = 0;

/// Steps of differences, so that the moment stays near: a tenth of a millimetre.
const NEAR: f64 = 0.005;

/// How a point of a rod passes something.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Pass {
    /// A ball that it passes by.
    Ball,
    /// An edge: it leaves one face for another.
    Edge,
    /// A face from which it comes where its piece of the motion begins.
    Begin,
    /// A face that it nears until that ends.
    End,
}

const PASSES: [Pass; 4] = [Pass::Ball, Pass::Edge, Pass::Begin, Pass::End];

/// Twice the way by which the point of the last rod leaves, in a little while before and after a time, the straight line on which it
/// goes past something \[m\].
fn drawn(
    problem: &TreeProblem,
    point: &TreePoint,
    from: &KeptFrom,
    other: usize,
    around_s: f64,
) -> Vector3<f64> {
    const WHILE_S: f64 = 1e-3;
    let mut snapshot = ForestSnapshot::new(&problem.forest, &problem.gravity_m_s2);
    let mut both = |time_s: f64| {
        let (acted_s, _) = point.time_line(problem).acted_s(time_s);
        snapshot.set(&problem.state_at(point, acted_s));
        let own = snapshot.link_state(LAST);
        let met = given_state(from, time_s).unwrap_or_else(|| snapshot.link_state(other));
        (own.position_m + own.orientation * POINT_M, met)
    };
    let (there, met) = both(around_s);
    let on_met = met.orientation.inverse() * (there - met.position_m);
    let mut apart = |time_s: f64| {
        let (there, met) = both(time_s);
        there - met.position_m - met.orientation * on_met
    };
    apart(around_s + WHILE_S) + apart(around_s - WHILE_S) - 2.0 * apart(around_s)
}

/// A point of the last rod keeps clear about a time of what moves as `from` says, or of the link at a place of the forest.
fn clearance(
    problem: &TreeProblem,
    point: &TreePoint,
    from: &KeptFrom,
    other: usize,
    around_s: f64,
    pass: Pass,
) -> TreeClearance {
    let mut snapshot = ForestSnapshot::new(&problem.forest, &problem.gravity_m_s2);
    let (about_s, _) = point.time_line(problem).acted_s(around_s);
    snapshot.set(&problem.state_at(point, about_s));
    let own = snapshot.link_state(LAST);
    let met = given_state(from, around_s).unwrap_or_else(|| snapshot.link_state(other));
    let there = own.position_m + own.orientation * POINT_M;
    let speed = |of: &State| {
        let spin = of.orientation * of.angular_velocity_rad_s;
        of.velocity_m_s + spin.cross(&(there - of.position_m))
    };
    let way = (speed(&own) - speed(&met)).normalize();
    let [across, _] = Feature::tangents(&way);
    // What is round is on the side from which the point is drawn: there it passes by.
    let across = across
        * drawn(problem, point, from, other, around_s)
            .dot(&across)
            .signum();
    let frame = Frame::of(&met);
    let seen = |place: &Vector3<f64>| frame.orientation.inverse() * (place - frame.position_m);
    let corner = Feature::corner(POINT_M);
    let touching = |feature: Feature| Contact::new(corner, feature).expect("a pair of features");
    let face = |normal: Vector3<f64>| {
        let normal = normal.normalize();
        let on_it = there + normal * 0.004;
        touching(Feature::face(
            seen(&on_it),
            frame.orientation.inverse() * normal,
        ))
    };
    let one = |contact: Contact| ClearanceTouches::One(Box::new(contact));
    let touches = match pass {
        Pass::Ball => one(touching(Feature::Point {
            point_m: seen(&(there - across * 0.03)),
            radius_m: 0.032,
        })),
        Pass::Edge => {
            ClearanceTouches::Switching(Box::new([face(across * 0.8 - way), face(across + way)]))
        }
        Pass::Begin => one(face(across * 0.4 + way)),
        Pass::End => one(face(across * 0.4 - way)),
    };
    let events_s = point.event_times_s.iter();
    TreeClearance {
        solids: ClearSolids {
            link: LinkIndex(LAST),
            against: Against::Link(LinkIndex(other)),
            from: from.clone(),
            touches,
            around_s,
            reach_s: match pass {
                Pass::Ball | Pass::Edge => 0.0025,
                Pass::Begin | Pass::End => 1.0,
            },
            least_m: -0.001,
            depth_m: 0.0,
        },
        places: [LAST, other],
        piece: MotionPiece {
            node: problem.node_of(about_s),
            events_before: events_s.filter(|event_s| **event_s < around_s).count(),
        },
        about_s,
    }
}

/// Checks clearances of all kinds about a time: that they are least where they should, and their derivatives.
fn check_kept(mut problem: TreeProblem, point: &TreePoint, around_s: f64) {
    let still = KeptFrom::Still(Frame {
        position_m: Vector3::new(0.1, -0.2, 0.3),
        orientation: crate::math::so3::exp(&Vector3::new(0.4, -0.3, 0.2)),
    });
    let mut others = vec![(still, LAST), (KeptFrom::Flying, FIRST)];
    let hands = problem.hands.iter();
    let held = hands.map(|hand| KeptFrom::Held(Box::new(hand.clone())));
    others.extend(held.map(|held| (held, LAST)));
    for (from, other) in &others {
        let each = PASSES.map(|pass| clearance(&problem, point, from, *other, around_s, pass));
        let line = point.time_line(&problem);
        for (of, pass) in each.iter().zip(PASSES) {
            let ends = of.piece.ends(&problem, &line, point);
            let least_s = problem.least_s(of, point).expect("a moment");
            let off_s = (least_s - around_s).abs();
            match pass {
                Pass::Ball | Pass::Edge => assert!(off_s < 0.002, "{pass:?}: {off_s}"),
                Pass::Begin => assert_eq!(least_s, ends[0].time_s, "{from:?}"),
                Pass::End => assert_eq!(least_s, ends[1].time_s, "{from:?}"),
            }
        }
        problem.clearances = each.to_vec();
        check_by(&problem, point, NEAR);
    }
}

/// Times that no difference leads over a kink of the tempo, with a clearance between the second and the third event.
const EVENTS_S: [f64; 4] = [0.015, 0.057, 0.064, 0.086];
const AROUND_S: f64 = 0.06;

/// Between a waypoint and an impact, and from a node on, by a tempo and by what is freed: of what stands, and of another rod.
#[test]
fn rows_of_clearances_are_those_of_differences() {
    const FREE: &str = "\n[[free]]\nquantity = \"hit.restitution\"\n\n[[free]]\nquantity = \"rod 2.mass\"\nprior_sd = 0.1\n";
    for stamps in ["\"physical\"", "\"tempo\"", &format!("\"physical\"{FREE}")] {
        let mut problem = struck(stamps);
        if let Some(tempo) = &mut problem.tempo {
            (tempo.knots_s, tempo.guess) = (vec![0.0, 0.05, 0.1], 0.9);
        }
        for nodes_s in [vec![0.0], vec![0.0, 0.0577]] {
            problem.nodes_s = nodes_s;
            let nodes = vec![some_state(&problem); problem.nodes_s.len()];
            let mut point = TreePoint::new(&problem, nodes);
            for (log, off) in point.log_paces.iter_mut().zip([0.1, -0.2]) {
                *log += off;
            }
            if let [restitution, mass] = point.parameters.as_mut_slice() {
                (*restitution, *mass) = (0.45, 1.1 * *mass);
            }
            let line = point.time_line(&problem);
            point.event_times_s = EVENTS_S.map(|acted_s| line.time_s(acted_s)).to_vec();
            let around_s = line.time_s(AROUND_S);
            check_kept(problem.clone(), &point, around_s);
        }
    }
}

/// Rods that hang from a hand, out of what stands, each other and the hand, which moves them whatever their states are.
#[test]
fn rows_of_clearances_in_a_hand_are_those_of_differences() {
    let mut problem = in_hand();
    for nodes_s in [vec![0.0], vec![0.0, 0.0585]] {
        problem.nodes_s = nodes_s;
        let nodes = problem.nodes_s.iter().map(|time_s| TreeState {
            time_s: *time_s,
            ..some_state(&problem)
        });
        let mut point = TreePoint::new(&problem, nodes.collect());
        point.event_times_s = EVENTS_S[1..3].to_vec();
        assert_eq!(problem.hands.len(), 1);
        check_kept(problem.clone(), &point, AROUND_S);
    }
}

/// A surface whose height is unknown takes what is kept out of it along.
#[test]
fn a_surface_that_moves_is_what_is_kept_clear_of() {
    const FREE: &str = "\n[[free]]\nquantity = \"table.height\"\n";
    let mut problem = struck(&format!("\"physical\"{FREE}"));
    let mut point = TreePoint::new(&problem, vec![some_state(&problem)]);
    point.event_times_s = EVENTS_S.to_vec();
    point.parameters = vec![-0.01];
    let still = KeptFrom::Still(Frame::world());
    let mut of = clearance(&problem, &point, &still, LAST, AROUND_S, Pass::Ball);
    let table = Feature::face(Vector3::new(0.0, 0.0, -0.3), Vector3::z());
    let contact = Contact::new(Feature::corner(POINT_M), table).expect("a corner and a face");
    of.solids.touches = ClearanceTouches::One(Box::new(contact));
    of.solids.against = Against::Surface(0);
    let block = problem.clearance_block(0);
    problem.clearances = vec![of];
    check_by(&problem, &point, NEAR);
    let program = TreeProgram::new(&problem, point.clone());
    let height_m = |point: &TreePoint| {
        let system = program.evaluated(&Part::whole(), point);
        0.01 * system.blocks[block].values[0]
    };
    let before_m = height_m(&point);
    point.parameters[0] += 0.02;
    // Rows after the impacts on it move along.
    assert!((height_m(&point) - before_m).abs() > 1e-3);
}
