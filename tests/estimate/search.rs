//! What touches is inferred where a scene does not say it: the same estimate as of a scene that
//! does, and the same sequence of collisions as by trying them all.

use enact_tools::perform;

use enact::estimate::schedule::recipe::{self, Recipe};
use enact::estimate::{Bound, Part};
use enact::motion::{Event, EventKind, Scene, VelocityGaps, Verdict};
use enact::optimise::lagrangian::AugmentedLagrangian;
use enact::pipeline::{Outcome, SearchWork};
use enact_tools::case::{Case, Posed, another_leads, estimated};
use enact_tools::open::{OPEN, RECORDINGS, opened, recorded, without_contacts};
use enact_tools::perform::{Acting, Polyhedron, Throw, bounces, thrown};

#[test]
fn scenes_that_name_no_contact_give_the_same_estimate() {
    for name in RECORDINGS {
        let outcome = |edit: fn(&str) -> String| -> Outcome {
            let pipeline = recorded(name, edit).unwrap_or_else(|error| panic!("{name}: {error}"));
            pipeline.finish(&mut ()).unwrap()
        };
        let named = outcome(str::to_owned);
        let open = outcome(without_contacts);
        assert!(named.inferred.is_empty());
        assert_eq!(open.inferred, named.scene_collisions(), "{name}");
        for event in &open.inferred {
            let words = [&named, &open].map(|o| o.scene.contact_words(*event).unwrap());
            assert_eq!(words[1], words[0], "{name}");
        }
        assert_eq!(open.estimate.arcs, named.estimate.arcs, "{name}");
        assert_eq!(open.estimate.verdict, named.estimate.verdict, "{name}");
        assert_eq!(open.estimate.objective, named.estimate.objective, "{name}");
    }
}

trait Collisions {
    fn scene_collisions(&self) -> Vec<usize>;
}

impl Collisions for Outcome {
    fn scene_collisions(&self) -> Vec<usize> {
        let events = self.scene.events.iter().enumerate();
        events
            .filter(|(_, event)| event.kind.collision().is_some())
            .map(|(index, _)| index)
            .collect()
    }
}

/// All sequences, each solved by the same estimator: the objective and events of the best that is
/// a motion, and how many there are.
fn enumerated(scene: &Scene, case: &Case) -> (f64, Vec<Event>, usize) {
    let open = scene.open_events();
    let candidates: Vec<_> = open.iter().map(|e| scene.candidates(*e)).collect();
    let count: usize = candidates.iter().map(Vec::len).product();
    let mut best = (f64::INFINITY, Vec::new(), count);
    for number in 0..count {
        let mut rest = number;
        let mut named = scene.clone();
        for (event, candidates) in open.iter().zip(&candidates) {
            named.set_contacts(*event, &candidates[rest % candidates.len()]);
            rest /= candidates.len();
        }
        let outcome = estimated(&named, &case.performance.events, &mut ()).unwrap();
        let objective = outcome.estimate.objective;
        let is_sound = outcome.estimate.verdict == Verdict::Physical && !another_leads(&outcome);
        if is_sound && objective < best.0 {
            best = (objective, outcome.scene.events, count);
        }
    }
    best
}

/// Bounces of a solid, of which nobody says what touches.
struct Bouncing {
    case: Case,
    scene: Scene,
    name: String,
}

impl Bouncing {
    fn new(solid: Polyhedron, bounces: usize, is_timing_known: bool, seed: u64) -> Self {
        let acting = if is_timing_known {
            Acting::timing_known()
        } else {
            Acting::default()
        };
        // What touches says where a mark that is far off belongs: here none is.
        let acting = Acting {
            mark_error_s: 0.0,
            ..acting
        };
        let mut truth = thrown(solid, &Throw::BOX, bounces, seed).unwrap();
        truth.scene.mark_sd_s = Some(0.001);
        let case = Case::new(&truth, &acting, seed).one_by_one();
        let mut scene = opened(case.scene());
        scene.velocity_gaps = VelocityGaps::Never;
        Self {
            case,
            scene,
            name: format!("{solid:?}, {bounces} bounces, {is_timing_known}, seed {seed}"),
        }
    }

    /// What is inferred is what trying all sequences finds; the work of the search, if there was
    /// one, and how many sequences there are.
    fn assert_exact(&self) -> (Option<SearchWork>, usize) {
        let found = estimated(&self.scene, &self.case.performance.events, &mut ()).unwrap();
        let (objective, events, count) = enumerated(&self.scene, &self.case);
        assert_eq!(found.scene.events, events, "{}", self.name);
        assert_eq!(found.estimate.objective, objective, "{}", self.name);
        (found.search, count)
    }
}

/// What the fits of the arcs do not tell is searched for, and proven without trying them all:
/// in some the likeliest sequence is the best, in some it is not.
#[test]
fn what_the_fits_do_not_tell_is_searched_for() {
    let (mut searched, mut surprises) = (0, 0);
    // Of most performances the fits tell enough.
    for seed in 0..80 {
        let bouncing = Bouncing::new(Polyhedron::Cube, 2, true, seed);
        let events = &bouncing.case.performance.events;
        let found = estimated(&bouncing.scene, events, &mut ()).unwrap();
        if found.search.is_none() || searched == 4 {
            continue;
        }
        searched += 1;
        let (work, count) = bouncing.assert_exact();
        let name = &bouncing.name;
        let work = work.unwrap_or_else(|| panic!("no search: {name}"));
        println!("{name}: {work:?}");
        assert!(work.is_proven, "{name}: {work:?}");
        let sequences = 2.0..=count as f64;
        assert!(sequences.contains(&work.sequences), "{name}: {work:?}");
        assert!((1..=count / 8).contains(&work.solves), "{name}: {work:?}");
        assert!(work.bounds > 0 && work.nodes > 0, "{name}: {work:?}");
        surprises += usize::from(work.solves > 1);
    }
    assert_eq!(searched, 4, "nothing is searched for");
    assert!(surprises > 0, "the likeliest sequence is always the best");
}

/// No bound of a sequence is above what the sequence costs, nor far below where it is done.
#[test]
fn bounds_are_below_what_they_bound_and_near() {
    for (is_timing_known, seed) in [(true, 16), (true, 45), (false, 3), (false, 6)] {
        let Bouncing { case, scene, name } =
            Bouncing::new(Polyhedron::Cube, 2, is_timing_known, seed);
        let outcome = case.estimated(&mut ()).unwrap();
        let posed = Posed::new(case.scene(), &outcome.sketch);
        let cost = 0.5 * outcome.estimate.objective;
        let arcs: Vec<usize> = (0..posed.segments.len()).collect();
        let part = |arcs| Part {
            scene: case.scene(),
            sketch: &outcome.sketch,
            segments: &posed.segments,
            arcs,
            guess: &posed.guesses[0],
            own_priors: true,
        };
        let mut whole = Bound::default();
        let mut last = 0.0;
        for share in [0.25, 0.5, 1.0, f64::INFINITY] {
            whole.tighten(&part(&arcs), share * cost, &Recipe::default());
            println!("{name}: {share} {} {cost}", whole.cost);
            assert!(whole.cost >= last, "{name}: {} after {last}", whole.cost);
            assert!(
                whole.cost <= cost * (1.0 + 1e-9),
                "{name}: {} > {cost}",
                whole.cost
            );
            assert!(whole.is_done() || whole.cost > share * cost, "{name}");
            last = whole.cost;
        }
        assert!(
            whole.is_done() && last > 0.95 * cost,
            "{name}: {last} < {cost}"
        );
        // Arcs by themselves are less than all of them tied.
        let mut alone = 0.0;
        for arc in &arcs {
            let mut bound = Bound::default();
            let part = &part(std::slice::from_ref(arc));
            bound.tighten(part, f64::INFINITY, &Recipe::default());
            assert!(bound.cost >= 0.0, "{name}: {arc}");
            alone += bound.cost;
        }
        println!("{name}: alone {alone} {cost}");
        assert!(alone > 0.0 && alone <= cost, "{name}: {alone} > {cost}");
        assert!(scene.open_events().len() == 2);
    }
}

/// Where constraints hold the dual value is the objective, whatever the multipliers are.
#[test]
fn the_dual_value_of_a_motion_is_its_cost() {
    let case = Case::pencil(perform::Style::Tip, &Acting::timing_known(), 3);
    let outcome = case.estimated(&mut ()).unwrap();
    let posed = Posed::new(case.scene(), &outcome.sketch);
    let (problem, layout) = (&posed.problem, &posed.layout);
    let recipe = Recipe::default();
    let solution = recipe::solve(problem, layout, &posed.guesses[0], &recipe, &mut ());
    assert!(solution.finished.converged);
    assert!(solution.multipliers.iter().any(|of_row| of_row.abs() > 1.0));
    for weight in [1e2, 1e4] {
        let mut lagrangian = AugmentedLagrangian::new(&solution.system, weight);
        lagrangian.multipliers.clone_from(&solution.multipliers);
        let (dual, cost) = (lagrangian.dual(&solution.system), solution.system.cost);
        assert!((dual - cost).abs() < 1e-6 * cost, "{dual} for {cost}");
        assert!(lagrangian.merit(&solution.system) > cost + 1e-6 * cost);
    }
}

/// The search finds what trying all sequences finds, for bounces with the timing known or not, at
/// these seeds. In all so many are tried, and so many solved by the search: as `tests/command/golden.rs`
/// says of its counters, a change is no error by itself.
fn assert_exact(
    solid: Polyhedron,
    (bounces, is_timing_known, seeds): (usize, bool, std::ops::Range<u64>),
    counts: (usize, usize),
) {
    let (mut tried, mut solved) = (0, 0);
    for seed in seeds {
        let bouncing = Bouncing::new(solid, bounces, is_timing_known, seed);
        let (search, count) = bouncing.assert_exact();
        tried += count;
        solved += search.map_or(1, |work| work.solves);
    }
    assert_eq!((tried, solved), counts);
}

#[test]
fn bounces_of_a_tetrahedron_are_those_that_all_sequences_give() {
    let exact = |of, counts| assert_exact(Polyhedron::Tetrahedron, of, counts);
    exact((1, true, 0..6), (24, 6));
    exact((1, false, 0..6), (24, 6));
    exact((2, true, 0..3), (48, 3));
    exact((2, false, 0..3), (48, 3));
    exact((3, true, 0..1), (64, 1));
    exact((3, false, 0..1), (64, 1));
}

#[test]
fn bounces_of_a_cube_are_those_that_all_sequences_give() {
    let exact = |of, counts| assert_exact(Polyhedron::Cube, of, counts);
    exact((1, true, 0..6), (48, 6));
    exact((1, false, 0..6), (48, 6));
    exact((2, true, 0..2), (128, 2));
    exact((2, false, 0..2), (128, 2));
}

#[test]
fn six_bounces_of_a_cube_are_found_without_trying_them_all() {
    for seed in 0..3 {
        let acting = Acting {
            distortion: 0.25,
            ..Acting::timing_known()
        };
        let case = Case::new(&bounces(6, seed).unwrap(), &acting, seed);
        let found = estimated(&opened(case.scene()), &case.performance.events, &mut ()).unwrap();
        assert_eq!(found.scene.events, case.scene().events, "seed {seed}");
        if let Some(work) = found.search {
            assert!(work.is_proven);
            assert!((2.0..=8f64.powi(6)).contains(&work.sequences));
            assert!(work.solves <= 10, "{} solves", work.solves);
        }
    }
}

#[test]
fn a_count_becomes_as_many_bounces_as_there_are_marks() {
    let truth = bounces(3, 4).unwrap();
    let case = Case::new(&truth, &Acting::timing_known(), 4);
    let mut scene = case.scene().clone();
    let EventKind::Collision(mut each) = scene.events[0].kind.clone() else {
        panic!("the first event is a bounce");
    };
    each.contacts = vec![OPEN];
    scene.contact_laws[each.law].restitution = 1.0;
    let kind = EventKind::Collisions {
        each,
        least: 1,
        most: 5,
    };
    scene
        .events
        .splice(0..3, [enact::motion::Event::new("bounce", kind)]);
    let found = estimated(&scene, &case.performance.events, &mut ()).unwrap();
    let names: Vec<&str> = found.scene.events.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(names, ["bounce 1", "bounce 2", "bounce 3", "end"]);
    assert!(!found.scene.has_repeats());
    assert!(found.scene.open_events().is_empty());
}
