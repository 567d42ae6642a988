//! Trees side by side, as one system: all that moves of a scene whose bodies may meet.
//!
//! A body by itself is a tree of one free link. Nothing but impacts couples one tree with another: flows and
//! mass matrices are block-diagonal.

pub(super) mod flow;
pub(super) mod snapshot;

use std::borrow::Cow;
use std::ops::Range;

use nalgebra::DMatrix;

use super::model::Tree;
use super::state::TreeState;

/// Trees side by side.
///
/// *Places* of links count through all trees, in their order. *Coordinates* are those of the trees, one after the
/// other, and so are *rates*; *tangents* are changes of all coordinates, then changes of all rates.
#[derive(Clone, Debug, PartialEq)]
pub struct Forest {
    trees: Vec<Tree>,
    /// Where each tree's numbers begin, and after the last where they end.
    begins: Vec<Begin>,
}

/// Numbers of links, coordinates and rates of all trees before one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Begin {
    link: usize,
    coordinate: usize,
    rate: usize,
}

impl Forest {
    /// The forest of some trees.
    ///
    /// # Panics
    /// Of none.
    pub fn new(trees: Vec<Tree>) -> Self {
        assert!(!trees.is_empty(), "something moves");
        let mut begins = vec![Begin::default()];
        for tree in &trees {
            let last = begins[begins.len() - 1];
            begins.push(Begin {
                link: last.link + tree.link_count(),
                coordinate: last.coordinate + tree.coordinate_count(),
                rate: last.rate + tree.freedoms(),
            });
        }
        Self { trees, begins }
    }

    /// Its trees.
    pub fn trees(&self) -> &[Tree] {
        &self.trees
    }

    /// Whether any of them hangs from a hand.
    pub fn is_in_hand(&self) -> bool {
        self.trees.iter().any(Tree::is_in_hand)
    }

    /// Number of links.
    pub fn link_count(&self) -> usize {
        self.begins[self.trees.len()].link
    }

    /// How long all hands that trees hang from move smoothly about a time \[s\]: no step of an integrator is longer.
    pub fn smooth_s(&self, time_s: f64) -> f64 {
        let hands = self.trees.iter().filter_map(|tree| tree.hand.as_ref());
        hands.fold(f64::INFINITY, |least, hand| {
            least.min(hand.smooth_s(time_s))
        })
    }

    /// Number of rates: degrees of freedom. Tangents are twice as long.
    pub fn freedoms(&self) -> usize {
        self.begins[self.trees.len()].rate
    }

    /// The tree of a link, and the link's place in that.
    pub fn tree_of(&self, place: usize) -> (usize, usize) {
        let after = self.begins.partition_point(|begin| begin.link <= place);
        (after - 1, place - self.begins[after - 1].link)
    }

    /// Places of a tree's rates among those of all.
    pub fn rates_of(&self, tree: usize) -> Range<usize> {
        self.begins[tree].rate..self.begins[tree + 1].rate
    }

    /// Places of a tree's tangent in that of all.
    pub(super) fn tangent_of(&self, tree: usize) -> impl Iterator<Item = usize> {
        let (rates, freedoms) = (self.rates_of(tree), self.freedoms());
        rates.clone().chain(rates.map(move |at| freedoms + at))
    }

    /// Places among the rates of what the joint leaves free from which a link hangs; of a free base, of its
    /// orientation.
    pub fn columns_of(&self, place: usize) -> Range<usize> {
        let (tree, link) = self.tree_of(place);
        let (own, begin) = (self.trees[tree].columns_of(link), self.begins[tree].rate);
        begin + own.start..begin + own.end
    }

    /// Places among the rates, and among the coordinates, of the angles of the pin or universal joint from which a
    /// link hangs; `None` of another joint.
    pub fn angles_of(&self, place: usize) -> Option<[Range<usize>; 2]> {
        let (tree, link) = self.tree_of(place);
        let Begin {
            coordinate, rate, ..
        } = self.begins[tree];
        let [rates, coordinates] = self.trees[tree].angles_of(link)?;
        Some([
            rate + rates.start..rate + rates.end,
            coordinate + coordinates.start..coordinate + coordinates.end,
        ])
    }

    /// Places among the rates of a link's velocity, if it is a free base; none of any other link.
    pub fn flight_of(&self, place: usize) -> Range<usize> {
        let (tree, link) = self.tree_of(place);
        let begin = self.begins[tree].rate;
        let shift = if link == 0 {
            self.trees[tree].translations()
        } else {
            0
        };
        begin..begin + shift
    }

    /// Whether a rate is of a free base's translation: not of an angle.
    pub fn is_translation(&self, rate: usize) -> bool {
        let after = self.begins.partition_point(|begin| begin.rate <= rate);
        rate - self.begins[after - 1].rate < self.trees[after - 1].translations()
    }

    /// A tree's part of a state of all.
    pub fn part<'s>(&self, state: &'s TreeState, tree: usize) -> Cow<'s, TreeState> {
        if self.trees.len() == 1 {
            return Cow::Borrowed(state);
        }
        let [from, to] = [self.begins[tree], self.begins[tree + 1]];
        Cow::Owned(TreeState {
            coordinates: state.coordinates[from.coordinate..to.coordinate].to_vec(),
            rates: state.rates[from.rate..to.rate].to_vec(),
            time_s: state.time_s,
        })
    }

    /// The state of all, of those of the trees at the time of the first.
    pub fn whole(&self, parts: impl IntoIterator<Item = TreeState>) -> TreeState {
        let mut parts = parts.into_iter();
        let mut whole = parts.next().expect("a forest has trees");
        for part in parts {
            whole.coordinates.extend(part.coordinates);
            whole.rates.extend(part.rates);
        }
        whole
    }

    /// At rest with all coordinates zero and all quaternions one.
    pub fn at_rest(&self) -> TreeState {
        let at_rest = self.whole(self.trees.iter().map(Tree::at_rest));
        let times_s = self.trees.iter().map(|tree| tree.at_rest().time_s);
        TreeState {
            time_s: times_s.sum(),
            ..at_rest
        }
    }

    /// `q ⊞ δ`, as of a [tree](Tree::retract).
    pub fn retract(&self, state: &TreeState, delta: &[f64]) -> TreeState {
        let parts = self.trees.iter().enumerate().map(|(index, tree)| {
            let own: Vec<f64> = self.tangent_of(index).map(|at| delta[at]).collect();
            tree.retract(&self.part(state, index), &own)
        });
        self.whole(parts)
    }

    /// `q ⊟ p` with `p = origin`, as of a [tree](Tree::minus).
    pub fn minus(&self, state: &TreeState, origin: &TreeState) -> Vec<f64> {
        let mut delta = vec![0.0; 2 * self.freedoms()];
        for (index, tree) in self.trees.iter().enumerate() {
            let own = tree.minus(&self.part(state, index), &self.part(origin, index));
            for (at, of) in self.tangent_of(index).zip(own) {
                delta[at] = of;
            }
        }
        delta
    }

    /// Derivatives of `q ⊟ p` by the tangents of `q` and of `p`, as of a [tree](Tree::minus_jacobians).
    pub fn minus_jacobians(&self, state: &TreeState, origin: &TreeState) -> [DMatrix<f64>; 2] {
        let size = 2 * self.freedoms();
        let mut by = [DMatrix::zeros(size, size), DMatrix::zeros(size, size)];
        for (index, tree) in self.trees.iter().enumerate() {
            let own = tree.minus_jacobians(&self.part(state, index), &self.part(origin, index));
            for (by, own) in by.iter_mut().zip(&own) {
                for (column, to) in self.tangent_of(index).enumerate() {
                    for (row, at) in self.tangent_of(index).enumerate() {
                        by[(at, to)] = own[(row, column)];
                    }
                }
            }
        }
        by
    }
}
