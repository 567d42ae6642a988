//! The ranking of candidates by fits of the motion about a collision.

use super::fitted::{Fitted, FittedView};
use super::ranking::{Ranking, Reach};
use super::solids::Solids;
use crate::motion::{Contacts, LinkIndex, Partner, Scene};
use crate::physics::contact::Frame;

/// Ranks the candidates of an open collision by fits about it.
///
/// There are none where no pair of features may touch.
pub fn ranked(scene: &Scene, event: usize, fitted: &dyn Fitted) -> Ranking {
    let view = FittedView {
        scene,
        event,
        fitted,
    };
    let mut candidates: Vec<Reach> = Vec::new();
    let all = scene.candidates(event);
    let Some(collision) = scene.events[event].kind.collision() else {
        return Ranking {
            event,
            candidates,
            spread_m: 0.0,
        };
    };
    match collision.partner {
        Partner::Link(_) => candidates.extend(view.against_solid(&all, None)),
        Partner::World => {
            for surface in 0..scene.surfaces.len() {
                let of_it = with_surfaces(&all, |other| other == surface);
                if scene.surfaces[surface].obstacle.is_none() {
                    candidates.extend(view.against_plane(&of_it));
                }
            }
            for obstacle in 0..scene.obstacles.len() {
                let of_it = with_surfaces(&all, |other| {
                    scene.surfaces[other].obstacle == Some(obstacle)
                });
                candidates.extend(view.against_solid(&of_it, Some(obstacle)));
            }
        }
    }
    candidates.sort_by(|a, b| a.reach_m.total_cmp(&b.reach_m));
    let links = view.links().into_iter();
    let spread_m = links.map(|link| fitted.spread_m(link)).fold(0.0, f64::max);
    // The distance of fits from samples, or half that of the first candidate from touching.
    let first_m = candidates.first().map_or(0.0, |first| first.reach_m);
    Ranking {
        event,
        candidates,
        spread_m: spread_m.max(0.5 * first_m),
    }
}

fn with_surfaces(all: &[Contacts], is_wanted: impl Fn(usize) -> bool) -> Vec<Contacts> {
    let wanted = |contacts: &&Contacts| contacts[0].other.is_some_and(&is_wanted);
    all.iter().filter(wanted).cloned().collect()
}

impl FittedView<'_> {
    /// Gap of contacts with a plane, the lowest of several, averaged over the fits that there are.
    fn gap_m(&self, contacts: &Contacts, link: LinkIndex) -> Option<f64> {
        let states = [false, true].map(|is_after| self.fitted.state(link, is_after, 0.0));
        let mut sum = (0.0, 0.0);
        for state in states.into_iter().flatten() {
            let frame = Frame::of(&state);
            let gaps = contacts.iter().filter_map(|touching| {
                let touch = self.contact(touching)?.touch(&frame, &Frame::world());
                Some(touch.ok()?.gap_m)
            });
            let lowest_m = gaps.fold(f64::INFINITY, f64::min);
            sum = (sum.0 + lowest_m, sum.1 + 1.0);
        }
        (sum.1 > 0.0 && sum.0.is_finite()).then_some(sum.0 / sum.1)
    }

    fn against_plane(&self, candidates: &[Contacts]) -> Vec<Reach> {
        let Some(link) = self.links().first().copied() else {
            return Vec::new();
        };
        let gaps: Vec<(&Contacts, f64)> = candidates
            .iter()
            .filter_map(|contacts| Some((contacts, self.gap_m(contacts, link)?)))
            .collect();
        let lowest_m = gaps
            .iter()
            .map(|(_, gap_m)| *gap_m)
            .fold(f64::INFINITY, f64::min);
        let reach = |(contacts, gap_m): (&Contacts, f64)| Reach {
            contacts: contacts.clone(),
            reach_m: lowest_m.abs() + gap_m - lowest_m,
        };
        gaps.into_iter().map(reach).collect()
    }

    /// Candidates against an obstacle, or against the other link.
    fn against_solid(&self, candidates: &[Contacts], obstacle: Option<usize>) -> Vec<Reach> {
        let Some(pair) = Solids::new(self, obstacle) else {
            return Vec::new();
        };
        let distance_m = pair.distance_m(0.0);
        let moment_s = pair.first_overlap_s();
        let gaps: Vec<(&Contacts, f64)> = candidates
            .iter()
            .filter_map(|contacts| {
                let gaps = contacts.iter().map(|touching| {
                    let contact = self.contact(touching)?;
                    pair.nearness_m(&contact, moment_s)
                });
                let farthest_m = gaps
                    .collect::<Option<Vec<f64>>>()?
                    .into_iter()
                    .fold(0.0, f64::max);
                Some((contacts, farthest_m))
            })
            .collect();
        let nearest_m = gaps
            .iter()
            .map(|(_, gap_m)| *gap_m)
            .fold(f64::INFINITY, f64::min);
        let reach = |(contacts, gap_m): (&Contacts, f64)| Reach {
            contacts: contacts.clone(),
            reach_m: distance_m.abs() + gap_m - nearest_m,
        };
        gaps.into_iter().map(reach).collect()
    }
}
