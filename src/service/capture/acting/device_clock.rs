//! When something happened on this machine's clock that a page timed by its own.

/// How long the shortest way is remembered \[ns\]: clocks drift apart by less than a tenth of a millisecond meanwhile.
const SPAN_NS: i64 = 5_000_000_000;

/// The least difference of arrival and device's time, of the last [`SPAN_NS`] and of those before.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DeviceClock {
    now: Option<ShortestWay>,
    before: Option<ShortestWay>,
}

#[derive(Clone, Copy, Debug)]
struct ShortestWay {
    began_ns: i64,
    offset_ns: i64,
}

impl DeviceClock {
    /// Takes in that something of that device time has arrived.
    pub(super) fn arrived(&mut self, device_ns: i64, receipt_ns: i64) {
        let offset_ns = receipt_ns.saturating_sub(device_ns);
        match &mut self.now {
            Some(now) if receipt_ns.saturating_sub(now.began_ns) < SPAN_NS => {
                now.offset_ns = now.offset_ns.min(offset_ns);
            }
            _ => {
                self.before = self.now.replace(ShortestWay {
                    began_ns: receipt_ns,
                    offset_ns,
                });
            }
        }
    }

    /// The time of arrival of what takes the shortest way; `None` before anything has arrived.
    pub(super) fn receipt_ns(&self, device_ns: i64) -> Option<i64> {
        let known = [self.now, self.before].into_iter().flatten();
        let offset_ns = known.map(|way| way.offset_ns).min()?;
        Some(device_ns.saturating_add(offset_ns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_held_up_is_timed_as_if_it_had_not_been() {
        let mut clock = DeviceClock::default();
        assert_eq!(clock.receipt_ns(7), None);
        for number in 0..1000_i64 {
            let device_ns = number * 11_111_111;
            // One in ten comes at once, the others are held up.
            let late_ns = 2_000_000 + (number % 10) * 3_000_000;
            clock.arrived(device_ns, 1_700_000_000_000_000_000 + device_ns + late_ns);
            let found_ns = clock.receipt_ns(device_ns).expect("known");
            assert_eq!(found_ns - device_ns, 1_700_000_000_002_000_000);
        }
        // A page that was opened anew has another clock, and is known after a while.
        for number in 0..1000_i64 {
            let at_ns = 20_000_000_000 + number * 11_111_111;
            clock.arrived(number * 11_111_111, at_ns);
        }
        assert_eq!(clock.receipt_ns(0), Some(20_000_000_000));
        clock.arrived(i64::MIN, i64::MAX);
        assert!(clock.receipt_ns(i64::MIN).is_some());
    }
}
