//! The map between acted and physical time.

use super::sample_time::SampleTime;
use super::take::Stamp;

/// Number of samples at each end from which the tempo beyond them is computed.
const TEMPO_SAMPLES: usize = 8;

/// Physical time as a function of acted time: linear between samples, and beyond them at the tempo
/// of the nearest few.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeMap {
    /// Pairs of acted and physical time \[s\].
    knots: Vec<(f64, f64)>,
    /// Physical per acted time before the first knot and after the last.
    tempos: (f64, f64),
}

impl TimeMap {
    /// The map of those of an estimate's samples whose stamps say when they were acted; acted times
    /// are relative to `origin`. `None` where fewer than two times differ, or where time stands still or runs backwards at an end.
    pub fn new(sample_times: &[SampleTime], origin: Stamp) -> Option<Self> {
        let times = sample_times.iter().filter(|sample| !sample.is_open);
        let mut knots: Vec<(f64, f64)> = times
            .map(|sample| (sample.stamp.seconds_since(origin), sample.time_s))
            .collect();
        knots.sort_by(|a, b| a.0.total_cmp(&b.0));
        knots.dedup_by_key(|knot| knot.0);
        if knots.len() < 2 {
            return None;
        }
        let ends = knots.len().min(TEMPO_SAMPLES);
        let tempo = |part: &[(f64, f64)]| {
            let (first, last) = (part[0], part[part.len() - 1]);
            (last.1 - first.1) / (last.0 - first.0)
        };
        let tempos = (tempo(&knots[..ends]), tempo(&knots[knots.len() - ends..]));
        (tempos.0 > 0.0 && tempos.1 > 0.0).then_some(Self { knots, tempos })
    }

    /// Physical time of an acted one \[s\].
    pub fn physical_s(&self, acted_s: f64) -> f64 {
        let (from, tempo) = self.piece(|knot| knot.0 <= acted_s);
        from.1 + (acted_s - from.0) * tempo
    }

    /// Acted time of a physical one \[s\].
    pub fn acted_s(&self, time_s: f64) -> f64 {
        let (from, tempo) = self.piece(|knot| knot.1 <= time_s);
        from.0 + (time_s - from.1) / tempo
    }

    /// The last knot for which `is_before` holds, and the tempo after it.
    fn piece(&self, is_before: impl Fn(&(f64, f64)) -> bool) -> ((f64, f64), f64) {
        let after = self.knots.partition_point(is_before);
        let from = self.knots[after.saturating_sub(1)];
        let tempo = match (after, self.knots.get(after)) {
            (0, _) => self.tempos.0,
            (_, None) => self.tempos.1,
            (_, Some(next)) => (next.1 - from.1) / (next.0 - from.0),
        };
        (from, tempo)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::TrackIndex;

    fn map(times_s: &[(f64, f64)]) -> Option<TimeMap> {
        let samples: Vec<SampleTime> = times_s
            .iter()
            .map(|(acted_s, time_s)| SampleTime {
                track: TrackIndex(0),
                stamp: Stamp((acted_s * 1e9).round() as i64),
                time_s: *time_s,
                is_open: false,
            })
            .collect();
        TimeMap::new(&samples, Stamp(0))
    }

    #[test]
    fn there_and_back_between_samples_and_beyond() {
        let map = map(&[(0.0, 1.0), (2.0, 1.5), (3.0, 3.5)]).expect("a map");
        assert_eq!(map.physical_s(1.0), 1.25);
        assert_eq!(map.physical_s(2.5), 2.5);
        // Beyond at the mean tempo of the few samples there are: 2.5 / 3.
        assert!((map.physical_s(6.0) - 6.0).abs() < 1e-12);
        assert!((map.physical_s(-3.0) + 1.5).abs() < 1e-12);
        for acted_s in [-3.0, 0.0, 0.7, 2.0, 2.9, 3.0, 5.0] {
            let back_s = map.acted_s(map.physical_s(acted_s));
            assert!((back_s - acted_s).abs() < 1e-12, "{acted_s}: {back_s}");
        }
    }

    #[test]
    fn no_map_of_one_sample_or_of_time_that_stands_still() {
        assert_eq!(map(&[(0.0, 1.0), (0.0, 1.0)]), None);
        assert_eq!(map(&[(0.0, 1.0), (1.0, 1.0)]), None);
    }
}
