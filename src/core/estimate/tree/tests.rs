//! The programs of a chain and of a flail with a box against differences.

mod clearance;

use nalgebra::{DMatrix, DVector, Vector3};
use typed_index_collections::TiVec;

use super::curvature::HessianRemainder;
use super::part::Part;
use super::point::TreePoint;
use super::problem::TreeProblem;
use super::program::TreeProgram;
use super::time_line::TimeLine;
use crate::config::scene_from_toml;
use crate::estimate::wander::likelihood::LikelyErrors;
use crate::math::differentiate;
use crate::math::random::Random;
use crate::motion::{MarkTime, Sample, Scene, Seen, Sketch, Stamp, TrackSketch};
use crate::optimise::Program;
use crate::physics::tree::TreeState;

fn scene() -> Scene {
    scene_from_toml(include_str!("../../../../config/chain.toml")).expect("a valid scene")
}

/// A tenth of a second of any path.
fn sketch(scene: &Scene) -> Sketch {
    sketch_of(scene, 11)
}

/// So many samples of any path, 10 ms apart.
fn sketch_of(scene: &Scene, count: usize) -> Sketch {
    let mut random = Random::default();
    let sample = |index: usize, at_m: Vector3<f64>| Sample {
        stamp: Stamp(index as i64 * 10_000_000),
        acted_s: 0.01 * index as f64,
        seen: Seen::Point(at_m),
    };
    let samples = (0..count).map(|index| sample(index, Vector3::from_fn(|_, _| random.signed())));
    let track = TrackSketch::new(samples.collect());
    Sketch {
        origin: Stamp(0),
        tracks: scene
            .tracks
            .iter()
            .map(|_| track.clone())
            .collect::<TiVec<_, _>>(),
        marks_s: vec![0.0, 0.01 * (count - 1) as f64],
        contacts_s: Default::default(),
        cuts_sd_s: Default::default(),
        marks: vec![None; 2],
    }
}

fn some_state(problem: &TreeProblem) -> TreeState {
    let mut random = Random::default();
    let delta: Vec<f64> = (0..problem.width()).map(|_| random.signed()).collect();
    problem.forest.retract(&problem.forest.at_rest(), &delta)
}

/// Gradient, rows of goals and rows of continuity, with one node and with three, where samples err by themselves and in time.
#[test]
fn derivatives_are_those_of_differences() {
    let scene = scene();
    let sketch = sketch(&scene);
    let mut problem = TreeProblem::new(&scene, &sketch);
    problem.step_s = 0.01;
    // One of the goals weighs instead.
    problem.goals[1].condition.sd = Some(0.2);
    for nodes_s in [vec![0.0], vec![0.0, 0.035, 0.07]] {
        problem.nodes_s = nodes_s;
        let nodes = vec![some_state(&problem); problem.nodes_s.len()];
        for errors in [None, Some(LikelyErrors::EXPECTED)] {
            problem.errors = errors;
            check(&problem, &TreePoint::new(&problem, nodes.clone()));
        }
    }
}

/// Rods that hang from a hand that swings, with a waypoint within a step and an impact.
fn in_hand() -> TreeProblem {
    let text = include_str!("../../../../config/chain.toml");
    let (before, after) = text.split_at(text.find("[[event]]\nname = \"end\"").expect("an end"));
    let way = "[[event]]\nname = \"by\"\nkind = \"waypoint\"\nbody = \"rod 2\"\n\n\
        [[surface]]\nname = \"table\"\npoint_mm = [0, 0, -300]\nnormal = [0, 0, 1]\n\n\
        [[event]]\nname = \"hit\"\nkind = \"collision\"\nbody = \"rod 3\"\nfeature = \"end\"\nsurface = \"table\"\nrestitution = 0.4\nfriction = 0.2\n\n";
    let asked = "\n[[goal]]\nevent = \"by\"\nbody = \"rod 2\"\nposition_mm = [100, 200, 300]\nvelocity_m_s = [1, 2, 3]\n\n\
        [[goal]]\nevent = \"by\"\nbody = \"rod 3\"\norientation_wxyz = [1, 0, 0, 0]\nspin_rad_s = [1, 2, 3]\n";
    let hand = "\n[[body]]\nname = \"hand\"\nheld = true\nshape = { kind = \"sphere\", radius_mm = 20 }\ntracker = {}\n\n\
        [[joint]]\nname = \"held\"\nkind = \"ball\"\nparent = \"hand\"\nparent_at_mm = [10, 20, -30]\nchild = \"rod 1\"\nchild_at_mm = [0, 0, 80]\n";
    let features = "mass_g = 100\nfeatures_mm = { end = [0, 0, -100] }\n";
    let text = before.to_owned() + way + after + asked + hand;
    let text = text.replace("mass_g = 100\n", features);
    let scene = scene_from_toml(&text).expect("a valid scene");
    let mut sketch = sketch(&scene);
    sketch.marks_s = vec![0.0, 0.044, 0.073, 0.1];
    sketch.marks = vec![None; 4];
    sketch.marks[1] = Some(MarkTime {
        acted_s: 0.044,
        sd_s: 0.01,
        counted: 1.0,
    });
    for (track, of) in sketch.tracks.iter_mut_enumerated() {
        if scene.sees_held(track) {
            for sample in &mut of.samples {
                let (sin, cos) = (20.0 * sample.acted_s).sin_cos();
                sample.seen = Seen::Pose {
                    position_m: Vector3::new(0.05 * sin, 0.03 * cos, sample.acted_s),
                    orientation: crate::math::so3::exp(&Vector3::new(0.2 * cos, 0.3 * sin, 0.1)),
                };
            }
        }
    }
    crate::segment::hold(&scene, &mut sketch).expect("a hand");
    let mut problem = TreeProblem::new(&scene, &sketch);
    assert!(problem.forest.trees()[0].is_in_hand());
    problem.step_s = 0.01;
    problem
}

/// Derivatives in a hand by times of events and by the states of three nodes.
#[test]
fn derivatives_in_a_hand_are_those_of_differences() {
    let mut problem = in_hand();
    for nodes_s in [vec![0.0], vec![0.0, 0.035, 0.07]] {
        problem.nodes_s = nodes_s;
        let nodes = problem.nodes_s.iter().map(|time_s| TreeState {
            time_s: *time_s,
            ..some_state(&problem)
        });
        check(&problem, &TreePoint::new(&problem, nodes.collect()));
    }
}

/// The last rod's end hits a table, the first rod's does without friction and with a tilt, and two waypoints
/// lie between and after: times that are before and after those of samples on either side.
const STRUCK: &str = r#"
[[surface]]
name = "table"
point_mm = [0, 0, -300]
normal = [0, 0, 1]

[[event]]
name = "hit"
kind = "collision"
body = "rod 3"
feature = "end"
surface = "table"
restitution = 0.6
friction = 0.2
earliest_ms = -30
latest_ms = 40

[[event]]
name = "by"
kind = "waypoint"
body = "rod 1"

[[event]]
name = "again"
kind = "collision"
body = "rod 1"
feature = "end"
surface = "table"
restitution = 0.3

[[event]]
name = "last"
kind = "waypoint"
body = "rod 2"

[[goal]]
event = "by"
body = "rod 2"
position_mm = [100, 200, 300]

[[goal]]
event = "hit"
body = "rod 3"
contact = true
position_mm = [30, -20, -300]

[[goal]]
event = "again"
body = "rod 3"
velocity_m_s = [0, 1, 2]
after = true
sd_m_s = 0.3

[[goal]]
event = "again"
body = "rod 2"
velocity_m_s = [1, 0, 0]

[[goal]]
event = "again"
since = "hit"
time_ms = 50

[[goal]]
event = "last"
time_ms = 70
sd_ms = 20

[[goal]]
event = "end"
since = "by"
time_within_ms = [60, 80]

"#;

/// [`STRUCK`], with stamps of this kind.
fn struck(stamps: &str) -> TreeProblem {
    let text = include_str!("../../../../config/chain.toml");
    let (before, after) = text.split_at(text.find("[[event]]\nname = \"end\"").expect("an end"));
    let features = "mass_g = 100\nfeatures_mm = { end = [0, 0, -100] }\n";
    let text = (before.to_owned() + STRUCK + after).replace("mass_g = 100\n", features);
    // What follows the stamps comes last.
    let (stamps, free) = stamps.split_once('\n').unwrap_or((stamps, ""));
    let text = text.replace("\"physical\"", stamps) + free;
    let scene = scene_from_toml(&text).expect("a valid scene");
    let mut sketch = sketch(&scene);
    sketch.marks_s = vec![0.0, 0.023, 0.044, 0.058, 0.093, 0.1];
    sketch.marks = sketch
        .marks_s
        .iter()
        .map(|mark_s| {
            Some(MarkTime {
                acted_s: mark_s + 0.002,
                sd_s: 0.01,
                counted: 1.0,
            })
        })
        .collect();
    let mut problem = TreeProblem::new(&scene, &sketch);
    problem.step_s = 0.01;
    problem
}

#[test]
fn derivatives_through_events_are_those_of_differences() {
    let mut problem = struck("\"physical\"");
    for nodes_s in [vec![0.0], vec![0.0, 0.03, 0.05]] {
        problem.nodes_s = nodes_s;
        let nodes = vec![some_state(&problem); problem.nodes_s.len()];
        let mut point = TreePoint::new(&problem, nodes);
        for (time_s, off_s) in point
            .event_times_s
            .iter_mut()
            .zip([0.011, -0.006, 0.004, 0.001])
        {
            *time_s += off_s;
        }
        check(&problem, &point);
    }
}

/// The same in a tempo that is not known: samples, nodes, the end and marks all move with it. Marks see a kink between two
/// pieces, which differences must not cross.
#[test]
fn derivatives_by_the_tempo_are_those_of_differences() {
    let mut problem = struck("\"tempo\"");
    for (knots_s, offs) in [
        (vec![0.0, 0.05, 0.1], vec![0.1, -0.2]),
        (
            vec![0.0, 0.027, 0.052, 0.077, 0.1],
            vec![0.2, -0.1, 0.3, -0.3],
        ),
    ] {
        let tempo = problem.tempo.as_mut().expect("an unknown tempo");
        (tempo.knots_s, tempo.guess) = (knots_s, 0.9);
        for nodes_s in [vec![0.0], vec![0.0, 0.03, 0.05]] {
            problem.nodes_s = nodes_s;
            let nodes = vec![some_state(&problem); problem.nodes_s.len()];
            let mut point = TreePoint::new(&problem, nodes);
            for (log, off) in point.log_paces.iter_mut().zip(&offs) {
                *log += off;
            }
            let line = point.time_line(&problem);
            let times_s = [0.015, 0.02, 0.081, 0.086].map(|acted_s| line.time_s(acted_s));
            point.event_times_s = times_s.to_vec();
            check(&problem, &point);
        }
        for event in &mut problem.events {
            (event.mark, event.window_s) = (None, None);
        }
    }
}

/// What of the laws of impacts is free: of a contact that slides, and of one without friction.
#[test]
fn derivatives_by_laws_of_impacts_are_those_of_differences() {
    const FREE: &str = r#"
[[free]]
quantity = "hit.restitution"
lower = 0.1
upper = 0.9

[[free]]
quantity = "hit.friction"
prior_sd = 0.1

[[free]]
quantity = "again.tilt"
cone_deg = 6

[[free]]
quantity = "again.restitution"
"#;
    for stamps in ["\"physical\"", "\"tempo\""] {
        let mut problem = struck(&format!("{stamps}{FREE}"));
        assert_eq!((problem.parameters.len(), problem.cones.len()), (5, 1));
        for nodes_s in [vec![0.0], vec![0.0, 0.03, 0.05]] {
            problem.nodes_s = nodes_s;
            let nodes = vec![some_state(&problem); problem.nodes_s.len()];
            let mut point = TreePoint::new(&problem, nodes);
            point.parameters = vec![0.45, 0.15, 0.02, -0.05, 0.35];
            check(&problem, &point);
        }
    }
}

/// What else of the scene is free: of all kinds that act on flows, rows of goals and events, and samples.
#[test]
fn derivatives_by_what_is_freed_are_those_of_differences() {
    const FREE: &str = r#"
[[free]]
quantity = "gravity.x"

[[free]]
quantity = "hit.restitution"

[[free]]
quantity = "rod 2.mass"
prior_sd = 0.1

[[free]]
quantity = "rod 2.centre.z"

[[free]]
quantity = "table.height"
"#;
    for (stamps, errors) in [
        ("\"physical\"", None),
        ("\"tempo\"", Some(LikelyErrors::EXPECTED)),
    ] {
        let mut problem = struck(&format!("{stamps}{FREE}"));
        assert!(problem.freed.is_some());
        problem.errors = errors;
        for nodes_s in [vec![0.0], vec![0.0, 0.03, 0.05]] {
            problem.nodes_s = nodes_s;
            let nodes = vec![some_state(&problem); problem.nodes_s.len()];
            let mut point = TreePoint::new(&problem, nodes);
            point.parameters = vec![0.3, 0.35, 1.2, 0.004, -0.01];
            check(&problem, &point);
        }
    }
}

#[test]
fn a_time_line_leads_there_and_back() {
    let mut problem = struck("\"tempo\"");
    problem.tempo.as_mut().expect("an unknown tempo").knots_s = vec![0.0, 0.03, 0.05, 0.1];
    let log_paces = [-0.5, 0.4, -1.2];
    let line = TimeLine::new(&problem, &log_paces);
    // A third of the way into the second piece.
    let told_s = 0.03 * (-0.5f64).exp() + 0.007 * 0.4f64.exp();
    assert!((line.time_s(0.037) - told_s).abs() < 1e-15);
    for acted_s in [-0.02, 0.0, 0.03, 0.037, 0.05, 0.09, 0.1, 0.13] {
        let (back_s, _) = line.acted_s(line.time_s(acted_s));
        assert!((back_s - acted_s).abs() < 1e-15, "{acted_s}: {back_s}");
        let numeric = differentiate::jacobian(1, 3, |delta| {
            let moved = [0, 1, 2].map(|piece| log_paces[piece] + delta[piece]);
            vec![TimeLine::new(&problem, &moved).time_s(acted_s)]
        });
        let mut given: Vec<f64> = line.by_log_paces(acted_s).collect();
        given.resize(3, 0.0);
        for (numeric, given) in numeric[0].iter().zip(given) {
            assert!((numeric - given).abs() < 1e-9, "{acted_s}");
        }
    }
}

/// A rod's end hits a box that flies by itself, which hits a table, and the chain's last rod its first; a second chain,
/// which hangs, stands between them in the scene.
#[test]
fn derivatives_through_meetings_are_those_of_differences() {
    const BODIES: &str = r#"
[[surface]]
name = "table"
point_mm = [0, 0, -300]
normal = [0, 0, 1]

[[body]]
name = "hanging"
shape = { kind = "capsule", length_mm = 300, radius_mm = 5 }
mass_g = 100

[[body.track]]
sees = "point"
tracker = { position_mm = [0, 0, 0] }

[[body]]
name = "box"
shape = { kind = "cuboid", size_mm = [60, 80, 100] }
mass_g = 150

[[body.track]]
sees = "point"
tracker = { position_mm = [0, 0, 0] }

[[joint]]
name = "nail"
kind = "ball"
parent_at_mm = [0, 100, 500]
child = "hanging"
child_at_mm = [0, 0, 150]

"#;
    const EVENTS: &str = r#"
[[event]]
name = "hit"
kind = "collision"
body = "rod 3"
feature = "end -z"
other = "box"
other_feature = "face +z"
restitution = 0.6
friction = 0.2

[[event]]
name = "fall"
kind = "collision"
body = "box"
feature = "corner -x -y -z"
surface = "table"
restitution = 0.4

[[event]]
name = "fold"
kind = "collision"
body = "rod 1"
feature = "side"
other = "rod 3"
other_feature = "end -z"
restitution = 0.3
friction = 0.5

[[event]]
name = "swing"
kind = "collision"
body = "hanging"
feature = "end -z"
other = "box"
other_feature = "face -x"
restitution = 0.3

[[goal]]
event = "hit"
body = "rod 3"
contact = true
relative_to = "box"
position_mm = [10, 20, 50]

[[goal]]
event = "fold"
body = "rod 1"
contact = true
position_mm = [0, 100, 200]
within_mm = 20

[[goal]]
event = "swing"
body = "box"
contact = true
position_within_mm = [[0, 20, -50], [100, 80, 50]]
sd_mm = 5

[[goal]]
event = "fall"
body = "box"
velocity_m_s = [0, 1, 2]
after = true
sd_m_s = 0.3

[[goal]]
event = "fold"
body = "box"
position_mm = [100, 200, 300]

"#;
    let text = include_str!("../../../../config/chain.toml");
    let (before, after) = text.split_at(text.find("[[event]]\nname = \"end\"").expect("an end"));
    let text = before.to_owned() + EVENTS + after;
    let (before, after) = text.split_at(text.find("[[joint]]").expect("a joint"));
    let text = before.to_owned() + BODIES + after;
    let scene = scene_from_toml(&text.replace("cylinder", "capsule")).expect("a valid scene");
    let mut sketch = sketch(&scene);
    sketch.marks_s = vec![0.0, 0.023, 0.044, 0.058, 0.083, 0.1];
    sketch.marks = vec![None; 6];
    let mut problem = TreeProblem::new(&scene, &sketch);
    assert_eq!(problem.forest.trees().len(), 3);
    problem.step_s = 0.01;
    for nodes_s in [vec![0.0], vec![0.0, 0.03]] {
        problem.nodes_s = nodes_s;
        let nodes = vec![some_state(&problem); problem.nodes_s.len()];
        let mut point = TreePoint::new(&problem, nodes);
        for (time_s, off_s) in point
            .event_times_s
            .iter_mut()
            .zip([0.011, -0.006, 0.004, 0.001])
        {
            *time_s += off_s;
        }
        check(&problem, &point);
    }
}

/// A motion of which errors grow too much is cut into intervals that lie on it; a calm one is not.
#[test]
fn a_motion_is_cut_where_errors_grow() {
    let scene = scene();
    let problem = TreeProblem {
        step_s: 0.002,
        ..TreeProblem::new(&scene, &sketch_of(&scene, 201))
    };
    let whole_s = problem.span_s[1];
    for (factor, is_cut) in [(0.1, false), (25.0, true)] {
        let mut state = some_state(&problem);
        state.rates.iter_mut().for_each(|rate| *rate *= factor);
        let point = TreePoint::new(&problem, vec![state]);
        let (cut, point) = problem.clone().cut(point, whole_s);
        assert_eq!(cut.nodes_s.len(), point.nodes.len());
        assert_eq!(cut.nodes_s.len() > 1, is_cut, "{:?}", cut.nodes_s);
        let lengths = cut.nodes_s.windows(2).map(|ends_s| ends_s[1] - ends_s[0]);
        assert!(lengths.into_iter().all(|length_s| length_s > 0.119));
        let program = TreeProgram::new(&cut, point.clone());
        let system = program.evaluated(&Part::whole(), &point);
        for node in 0..cut.nodes_s.len() - 1 {
            let off = &system.blocks[cut.join_block(node)].values;
            assert!(off.iter().all(|off| off.abs() < 1e-6), "{node}: {off:?}");
        }
        // Followed as far as errors let it, by a share of that, and on to the end.
        let from_s = 0.2;
        let all_s = problem.followed_s(&point, from_s, whole_s, 1.0);
        let half_s = problem.followed_s(&point, from_s, whole_s, 0.5);
        assert!(from_s < half_s && half_s < all_s && all_s <= whole_s);
        assert_eq!(all_s == whole_s, !is_cut);
    }
}

/// What the Hessian lacks, told of all intervals at once, is what is told along every unknown by itself.
#[test]
fn curvature_of_legs_is_that_along_all_unknowns() {
    let scene = scene();
    let mut problem = TreeProblem::new(&scene, &sketch(&scene));
    problem.step_s = 0.01;
    problem.nodes_s = vec![0.0, 0.05];
    let nodes = vec![some_state(&problem); 2];
    let point = TreePoint::new(&problem, nodes);
    let program = TreeProgram::new(&problem, point.clone());
    let rows = program.evaluated(&Part::whole(), &point).row_count();
    let multipliers: Vec<f64> = (0..rows).map(|row| (row as f64).sin()).collect();
    let size = problem.unknown_count();
    let whole = Part::whole();
    let all = HessianRemainder::along(
        &program,
        &whole,
        &DMatrix::identity(size, size),
        &point,
        &multipliers,
    );
    let intervals =
        HessianRemainder::on_intervals(&program, &whole, &problem, &point, &multipliers);
    let width = problem.width();
    let largest = all.matrix().amax();
    for (row, column) in (0..size).flat_map(|row| (0..size).map(move |column| (row, column))) {
        let (all, intervals) = (
            all.matrix()[(row, column)],
            intervals.matrix()[(row, column)],
        );
        if row / width == column / width {
            assert!(
                (all - intervals).abs() < 1e-3 * largest,
                "{row} {column}: {all} {intervals}"
            );
        } else {
            assert_eq!(intervals, 0.0);
        }
    }
    assert!(largest > 1.0);
}

fn check(problem: &TreeProblem, point: &TreePoint) {
    check_by(problem, point, 1.0);
}

/// The same by differences of so many times the steps.
fn check_by(problem: &TreeProblem, point: &TreePoint, scale: f64) {
    let rest = vec![problem.forest.at_rest(); point.nodes.len()];
    let of = TreeProgram::new(problem, TreePoint::new(problem, rest));
    let part = Part::whole();
    let here = of.evaluated(&part, point);
    let size = of.structure().size();
    assert!(here.cost.is_finite());
    // A trial tells the same values, to the bit.
    let mut trial = here.clone();
    of.try_out(&part, point, &mut trial);
    assert_eq!(trial.cost, here.cost);
    assert!(trial.values().eq(here.values()));
    assert_ne!(trial.gradient, here.gradient);
    of.differentiate(&part, point, &mut trial);
    assert_eq!(trial.gradient, here.gradient);
    // Times move within what is smooth about them.
    let times = problem.unknown_of_event(0)..problem.unknown_of_event(problem.events.len());
    let first = problem.unknown_of_parameter(0);
    let length = |column: usize| {
        scale
            * match column.checked_sub(first) {
                Some(parameter) => problem.parameters[parameter].quantity.typical(),
                None if times.contains(&column) => 0.05,
                None => 1.0,
            }
    };
    let values = |delta: &[f64]| {
        let mut moved = point.clone();
        let step = DVector::from_fn(size, |at, _| length(at) * delta[at]);
        of.retract(point, &step, &mut moved);
        let there = of.evaluated(&part, &moved);
        std::iter::once(there.cost).chain(there.values()).collect()
    };
    let rows = 1 + here.row_count();
    let numeric = differentiate::jacobian(rows, size, values);
    for column in 0..size {
        let mut step = DVector::zeros(size);
        step[column] = 1.0;
        let mut along = Vec::new();
        here.along(of.structure(), &step, &mut along);
        along.insert(0, here.gradient[column]);
        for (row, given) in along.iter().enumerate() {
            let given = length(column) * given;
            let error = (numeric[row][column] - given).abs() / (1.0 + given.abs());
            assert!(error < 1e-6, "{row} {column}: {error}");
        }
    }
}
