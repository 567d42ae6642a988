//! Reasons why a take cannot become a sketch.

use thiserror::Error;

/// Why a take cannot become a sketch of the scene. Times are seconds since the first sample.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SegmentError {
    /// Nothing was delivered.
    #[error("the take has no samples, expected poses on {topics}")]
    NoSamples {
        /// Topics of all bodies.
        topics: String,
    },
    /// Nothing of one body can be used.
    #[error("body {body:?} has no usable samples on {topic:?}: {read} read{dropped}")]
    NoSamplesOfBody {
        /// Name of the body.
        body: String,
        /// Its topic.
        topic: String,
        /// Number of samples delivered for it.
        read: usize,
        /// Why they were left out: `, 3 not_finite`.
        dropped: String,
    },
    /// Too few samples of a body in the hand to smooth.
    #[error(
        "body {body:?} is held and has {samples} usable samples, expected at least {expected}: it moves \
         as it was tracked"
    )]
    HeldSamples {
        /// Name of the body.
        body: String,
        /// Number of its samples.
        samples: usize,
        /// At least.
        expected: usize,
    },
    /// Joined bodies hang from a hand that is not seen for a while.
    #[error(
        "body {body:?} is held, bodies hang from it, and it is not seen between {from_s:.3} s and {to_s:.3} s, expected \
         a sample at least every {within_s} s from the start to the end"
    )]
    HeldGap {
        /// Name of the body.
        body: String,
        /// When the gap begins [s since the sketch's origin],
        from_s: f64,
        /// and ends.
        to_s: f64,
        /// Longest gap \[s\].
        within_s: f64,
    },
    /// The samples of a body in the hand are so far apart that their motion cannot be computed.
    #[error(
        "body {body:?} is held and its samples are too far apart to be smoothed: are the positions in \
         metres?"
    )]
    HeldNotFinite {
        /// Name of the body.
        body: String,
    },
    /// A body in the hand that was not tracked when it hit something.
    #[error(
        "body {body:?} is held and was not tracked at {event:?}, at {time_s:.3} s: {}, expected samples \
         within {within_s} s before and after it; move the mark, or record the body there",
        apart(*before_s, *after_s)
    )]
    HeldUnseen {
        /// Name of the body.
        body: String,
        /// Name of the event.
        event: String,
        /// When it happens.
        time_s: f64,
        /// How long before it the nearest sample is \[s\], if there is one.
        before_s: Option<f64>,
        /// How long after it the nearest sample is \[s\], if there is one.
        after_s: Option<f64>,
        /// At most.
        within_s: f64,
    },
    /// A sample of a track that the scene does not have.
    #[error("a sample of track number {track}, expected one of {tracks}")]
    NoSuchTrack {
        /// Index of the track as delivered.
        track: usize,
        /// Number of tracks of the scene.
        tracks: usize,
    },
    /// A sample on a stream beyond those that the scene's events require.
    #[error("a sample on stream {stream} of body {body:?}, expected 1 to {streams}")]
    NoSuchStream {
        /// The body's name.
        body: String,
        /// Number of the stream as delivered, from 1.
        stream: usize,
        /// Number of streams that the scene requires.
        streams: usize,
    },
    /// Stamps that cannot be of one take.
    #[error("the samples span {span_s} s, expected at most {limit_s} s: are two clocks mixed?")]
    Span {
        /// From first to last.
        span_s: f64,
        /// At most.
        limit_s: f64,
    },
    /// Positions that cannot be in metres.
    #[error(
        "body {body:?} goes {reach_m:.1} m, {:.0} times its size of {size_m:.3} m, at {speed_m_s:.1} m/s \
         in the median: are the positions in millimetres? Expected metres",
        reach_m / size_m
    )]
    Units {
        /// The body's name.
        body: String,
        /// Distance from the middle sample within which nine tenths of its samples lie.
        reach_m: f64,
        /// Diameter of the ball that holds it.
        size_m: f64,
        /// Median speed.
        speed_m_s: f64,
    },
    /// More or fewer marks than events.
    #[error("{found} marks, expected {expected}{events}")]
    MarkCount {
        /// Number of marks in the take.
        found: usize,
        /// Number of events of the scene.
        expected: usize,
        /// For the message: names of the events, `: "release", "bounce"`, those that no mark names,
        /// and the proposals.
        events: String,
    },
    /// A mark names an event that the scene does not have.
    #[error("a mark at {time_s:.3} s is for {name:?}, expected one of {events}")]
    UnknownMark {
        /// As named.
        name: String,
        /// When it was made.
        time_s: f64,
        /// The scene's events.
        events: String,
    },
    /// Two marks name the same event.
    #[error("two marks for {event:?}, at {first_s:.3} s and {second_s:.3} s, expected one")]
    DuplicateMark {
        /// The event.
        event: String,
        /// Earlier mark.
        first_s: f64,
        /// Later mark.
        second_s: f64,
    },
    /// Marks do not follow the order of the scene's events.
    #[error(
        "the mark of {later:?} is at {later_s:.3} s, expected after that of {earlier:?} at {earlier_s:.3} s"
    )]
    MarkOrder {
        /// Event that the scene has first.
        earlier: String,
        /// Its mark.
        earlier_s: f64,
        /// Event that the scene has next.
        later: String,
        /// Its mark.
        later_s: f64,
    },
    /// A mark lies where there are no samples.
    #[error(
        "the mark of {event:?} is at {time_s:.3} s, outside the data: expected {first_s:.3} to {last_s:.3} s"
    )]
    MarkOutsideData {
        /// The event.
        event: String,
        /// Its mark.
        time_s: f64,
        /// First sample of the bodies that take part.
        first_s: f64,
        /// Last sample of the bodies that take part.
        last_s: f64,
    },
    /// Where bodies stick together nobody sees.
    #[error(
        "bodies `{}` and `{}` stick together from `{event}` on, and no tracker sees both at one time after it: where they stick \
         is as trackers show it",
        bodies[0],
        bodies[1]
    )]
    NotSeenStuck {
        /// The event.
        event: String,
        /// Names of the bodies.
        bodies: [String; 2],
    },
    /// Too little data between two events.
    #[error(
        "body `{body}` has {samples} usable samples between {from} and {to}: at least \
         {expected} are needed"
    )]
    TooFewSamples {
        /// The body's name.
        body: String,
        /// Number of usable samples.
        samples: usize,
        /// Least number needed.
        expected: usize,
        /// Event at the segment's start, or "the beginning".
        from: String,
        /// Event at its end, or "the end of the data".
        to: String,
    },
}

/// How far the nearest samples are from an event, in words.
fn apart(before_s: Option<f64>, after_s: Option<f64>) -> String {
    let side = |apart_s: Option<f64>, word: &str| match apart_s {
        Some(apart_s) => format!("the nearest sample {word} it is {apart_s:.3} s away"),
        None => format!("there is no sample {word} it"),
    };
    format!("{}, {}", side(before_s, "before"), side(after_s, "after"))
}
