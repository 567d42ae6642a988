//! What is compared: ways to move a tree's angular state on.

use enact::physics::tree::tableau::{DORMAND_PRINCE, Tableau};
use enact::physics::tree::{Flow, TreeState};

use super::cases::Case;
use super::collocation::Collocation;
use super::library::{self, Scheme};
use super::lie;
use super::system::System;

/// The classic method of Kutta.
pub const CLASSIC: Tableau = Tableau {
    a: &[&[], &[0.5], &[0.0, 0.5], &[0.0, 0.0, 1.0]],
    b: &[1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0],
    order: 4,
    dense: None,
};

/// The method of order six of Butcher ("On Runge–Kutta processes of high order", Journal of the
/// Australian Mathematical Society 4, 1964): seven stages, the fewest possible.
pub const BUTCHER: Tableau = Tableau {
    a: &[
        &[],
        &[1.0 / 3.0],
        &[0.0, 2.0 / 3.0],
        &[1.0 / 12.0, 1.0 / 3.0, -1.0 / 12.0],
        &[-1.0 / 16.0, 9.0 / 8.0, -3.0 / 16.0, -3.0 / 8.0],
        &[0.0, 9.0 / 8.0, -3.0 / 8.0, -3.0 / 4.0, 0.5],
        &[
            9.0 / 44.0,
            -9.0 / 11.0,
            63.0 / 44.0,
            18.0 / 11.0,
            0.0,
            -16.0 / 11.0,
        ],
    ],
    b: &[
        11.0 / 120.0,
        0.0,
        27.0 / 40.0,
        27.0 / 40.0,
        -4.0 / 15.0,
        -4.0 / 15.0,
        11.0 / 120.0,
    ],
    order: 6,
    dense: None,
};

/// A way.
#[derive(Clone, Copy)]
pub enum Way {
    /// The program's flow with a method's coefficients.
    Flow(Tableau),
    /// On the group.
    Lie(Tableau),
    /// Implicit, of so many stages.
    Gauss(usize),
    /// Implicit, of three.
    Radau,
    /// Steps by tolerance.
    Library(Scheme),
}

/// Name, and the way.
pub const METHODS: [(&str, Way); 11] = [
    ("RK4", Way::Flow(CLASSIC)),
    ("Butcher 6", Way::Flow(BUTCHER)),
    (PROGRAM, Way::Flow(DORMAND_PRINCE)),
    ("Munthe-Kaas RK4", Way::Lie(CLASSIC)),
    ("Munthe-Kaas DOP853", Way::Lie(DORMAND_PRINCE)),
    ("Gauss 2 stages", Way::Gauss(2)),
    ("Gauss 3 stages", Way::Gauss(3)),
    ("Gauss 4 stages", Way::Gauss(4)),
    ("Radau 3 stages", Way::Radau),
    ("adaptive DOP853", Way::Library(Scheme::DormandPrince853)),
    ("adaptive Verner 9", Way::Library(Scheme::Verner9)),
];

/// The program's final one.
pub const PROGRAM: &str = "DOP853, fixed steps";

/// How finely.
#[derive(Clone, Copy)]
pub enum Setting {
    /// So many equal steps.
    Steps(usize),
    /// Relative and absolute tolerance.
    Tolerance(f64),
}

impl Setting {
    /// In words.
    pub fn name(&self) -> String {
        match self {
            Self::Steps(steps) => format!("{steps} steps"),
            Self::Tolerance(tolerance) => format!("{tolerance:.0e}"),
        }
    }
}

impl Way {
    /// Settings that are measured, from coarse to fine.
    pub fn settings(&self, is_quick: bool) -> Vec<Setting> {
        let keep = |index: usize| !is_quick || index % 4 == 2;
        match self {
            Self::Library(_) => {
                let digits = (3..=13).filter(|digits| keep(*digits as usize));
                digits
                    .map(|digits| Setting::Tolerance(10_f64.powi(-digits)))
                    .collect()
            }
            Self::Gauss(_) | Self::Radau => steps(4..12, keep),
            _ => steps(3..13, keep),
        }
    }
}

fn steps(powers: std::ops::Range<usize>, keep: impl Fn(usize) -> bool) -> Vec<Setting> {
    powers
        .filter(|power| keep(*power))
        .map(|power| Setting::Steps(1 << power))
        .collect()
}

/// A way made ready for a case.
pub struct Ready<'c> {
    case: &'c Case,
    way: Way,
    system: System<'c>,
    flow: Flow<'c>,
    collocation: Collocation,
}

impl<'c> Ready<'c> {
    /// Room for it.
    pub fn new(case: &'c Case, way: Way) -> Self {
        let tableau = match way {
            Way::Flow(tableau) => tableau,
            _ => DORMAND_PRINCE,
        };
        let collocation = match way {
            Way::Gauss(stages) => Collocation::gauss(stages),
            _ => Collocation::radau(),
        };
        Self {
            case,
            way,
            system: System::new(case),
            flow: Flow::new(&case.tree, &case.gravity_m_s2, tableau),
            collocation,
        }
    }

    /// The end, none where the method does not get there, and the number of right sides.
    pub fn run(&mut self, setting: Setting) -> (Option<TreeState>, usize) {
        let (case, system) = (self.case, &mut self.system);
        let duration_s = case.duration_s;
        if let (Way::Flow(tableau), Setting::Steps(steps)) = (self.way, setting) {
            self.flow.begin(&case.start, false);
            self.flow.advance(duration_s, steps);
            let end = self.flow.state();
            let is_there = end
                .coordinates
                .iter()
                .chain(&end.rates)
                .all(|x| x.is_finite());
            return (is_there.then_some(end), steps * tableau.b.len());
        }
        system.count = 0;
        let mut y = system.list(&case.start);
        let is_there = match (self.way, setting) {
            (Way::Lie(tableau), Setting::Steps(steps)) => {
                lie::advance(system, &mut y, duration_s, steps, &tableau);
                true
            }
            (Way::Gauss(_) | Way::Radau, Setting::Steps(steps)) => {
                self.collocation.advance(system, &mut y, duration_s, steps)
            }
            (Way::Library(scheme), Setting::Tolerance(tolerance)) => {
                library::advance(system, &mut y, duration_s, scheme, tolerance)
            }
            _ => false,
        };
        let is_there = is_there && y.iter().all(|x| x.is_finite());
        (is_there.then(|| system.state(&y)), system.count)
    }
}
