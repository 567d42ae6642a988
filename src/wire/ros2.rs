//! Motion → ROS 2 messages, as little-endian CDR with their definitions.

use super::encode::{EncodeError, JointState, SchemaRecord, Transform};
use crate::motion::{PoseSample, Stamp};

const NANOSECONDS_PER_SECOND: i64 = 1_000_000_000;

/// Separator between a definition and the definitions of its parts.
const RULE: &str =
    "================================================================================\n";

const POSE_STAMPED: &[&str] = &[
    "std_msgs/Header header\ngeometry_msgs/Pose pose\n",
    HEADER_PART,
    TIME_PART,
    "MSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
    "MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n",
    QUATERNION_PART,
];

const TF_MESSAGE: &[&str] = &[
    "geometry_msgs/TransformStamped[] transforms\n",
    "MSG: geometry_msgs/TransformStamped\nstd_msgs/Header header\nstring child_frame_id\n\
     geometry_msgs/Transform transform\n",
    HEADER_PART,
    TIME_PART,
    "MSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\n\
     geometry_msgs/Quaternion rotation\n",
    "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n",
    QUATERNION_PART,
];

const JOINT_STATE: &[&str] = &[
    "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n",
    HEADER_PART,
    TIME_PART,
];

const HEADER: &[&str] = &[
    "builtin_interfaces/Time stamp\nstring frame_id\n",
    TIME_PART,
];
const STRING: &[&str] = &["string data\n"];

const HEADER_PART: &str = "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n";
const TIME_PART: &str = "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
const QUATERNION_PART: &str =
    "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n";

/// The kinds of ROS 2 messages that are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RosMessage {
    /// `geometry_msgs/msg/PoseStamped`.
    PoseStamped,
    /// `tf2_msgs/msg/TFMessage`.
    TfMessage,
    /// `sensor_msgs/msg/JointState`.
    JointState,
    /// `std_msgs/msg/Header`: an instant, with a name in `frame_id`.
    Header,
    /// `std_msgs/msg/String`.
    String,
}

impl RosMessage {
    const ALL: [Self; 5] = [
        Self::PoseStamped,
        Self::TfMessage,
        Self::JointState,
        Self::Header,
        Self::String,
    ];

    /// The kind whose schema has that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|kind| kind.schema().name == name)
    }

    /// Name and definition.
    pub fn schema(self) -> SchemaRecord {
        let (name, parts) = match self {
            RosMessage::PoseStamped => ("geometry_msgs/msg/PoseStamped", POSE_STAMPED),
            RosMessage::TfMessage => ("tf2_msgs/msg/TFMessage", TF_MESSAGE),
            RosMessage::JointState => ("sensor_msgs/msg/JointState", JOINT_STATE),
            RosMessage::Header => ("std_msgs/msg/Header", HEADER),
            RosMessage::String => ("std_msgs/msg/String", STRING),
        };
        SchemaRecord {
            name: name.to_owned(),
            encoding: "ros2msg".to_owned(),
            data: parts.join(RULE).into_bytes(),
        }
    }
}

/// A `geometry_msgs/msg/PoseStamped`.
pub fn pose_stamped(frame_id: &str, sample: &PoseSample) -> Result<Vec<u8>, EncodeError> {
    let mut cdr = CdrWriter::new();
    cdr.header(sample.stamp, frame_id)?;
    cdr.pose(sample);
    Ok(cdr.bytes)
}

/// A `tf2_msgs/msg/TFMessage` of any number of transforms.
pub fn tf_message(transforms: &[Transform]) -> Result<Vec<u8>, EncodeError> {
    let mut cdr = CdrWriter::new();
    cdr.length(transforms.len());
    for transform in transforms {
        cdr.header(transform.sample.stamp, transform.parent)?;
        cdr.text(transform.child);
        cdr.pose(&transform.sample);
    }
    Ok(cdr.bytes)
}

/// A `sensor_msgs/msg/JointState` of any number of joints. Its rates are of all or of none: the message knows no
/// other way to leave one out.
pub fn joint_state(at: Stamp, joints: &[JointState]) -> Result<Vec<u8>, EncodeError> {
    let mut cdr = CdrWriter::new();
    cdr.header(at, "")?;
    cdr.length(joints.len());
    joints.iter().for_each(|joint| cdr.text(joint.name));
    cdr.numbers(joints.iter().map(|joint| joint.angle_rad));
    let rates: Option<Vec<f64>> = joints.iter().map(|joint| joint.rate_rad_s).collect();
    cdr.numbers(rates.unwrap_or_default().into_iter());
    // No efforts: nothing drives the joints.
    cdr.length(0);
    Ok(cdr.bytes)
}

/// A `std_msgs/msg/Header` of an instant, with a name as its `frame_id`.
pub fn header(stamp: Stamp, name: &str) -> Result<Vec<u8>, EncodeError> {
    let mut cdr = CdrWriter::new();
    cdr.header(stamp, name)?;
    Ok(cdr.bytes)
}

/// A `std_msgs/msg/String`.
pub fn string(text: &str) -> Vec<u8> {
    let mut cdr = CdrWriter::new();
    cdr.text(text);
    cdr.bytes
}

/// Bytes of a message in little-endian CDR: each number is aligned to its size, counted from the
/// first byte after the encapsulation header.
struct CdrWriter {
    bytes: Vec<u8>,
}

impl CdrWriter {
    const MARK: [u8; 4] = [0, 1, 0, 0];

    fn new() -> Self {
        Self {
            bytes: Self::MARK.to_vec(),
        }
    }

    fn number<const N: usize>(&mut self, bytes: [u8; N]) {
        let length = self.bytes.len() - Self::MARK.len();
        let aligned = Self::MARK.len() + length.next_multiple_of(N);
        self.bytes.resize(aligned, 0);
        self.bytes.extend_from_slice(&bytes);
    }

    fn length(&mut self, length: usize) {
        let length = u32::try_from(length).expect("messages of ours are far below 4 GB");
        self.number(length.to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.length(text.len() + 1);
        self.bytes.extend_from_slice(text.as_bytes());
        self.bytes.push(0);
    }

    fn numbers(&mut self, numbers: impl ExactSizeIterator<Item = f64>) {
        self.length(numbers.len());
        numbers.for_each(|number| self.number(number.to_le_bytes()));
    }

    /// Appends a header. Its seconds are signed 32-bit numbers.
    fn header(&mut self, stamp: Stamp, frame_id: &str) -> Result<(), EncodeError> {
        let seconds = i32::try_from(stamp.0.div_euclid(NANOSECONDS_PER_SECOND))
            .map_err(|_| EncodeError::RosStamp(stamp.0))?;
        let nanoseconds = stamp.0.rem_euclid(NANOSECONDS_PER_SECOND);
        let nanoseconds = u32::try_from(nanoseconds).expect("a remainder below 10^9 fits");
        self.number(seconds.to_le_bytes());
        self.number(nanoseconds.to_le_bytes());
        self.text(frame_id);
        Ok(())
    }

    fn pose(&mut self, sample: &PoseSample) {
        let numbers = sample.position_m.iter().chain(&sample.quaternion_xyzw);
        numbers.for_each(|number| self.number(number.to_le_bytes()));
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::wire::decode::{MarkFormat, PoseFormat};

    type Header = ((i32, u32), String);

    fn sample(k: i64) -> PoseSample {
        PoseSample::new(
            Stamp(1_700_000_000_123_456_789 + k),
            Vector3::new(0.1, -2.0, k as f64),
            [0.0, 0.6, 0.0, 0.8],
        )
    }

    fn theirs<T: serde::Serialize>(value: &T) -> Vec<u8> {
        cdr::serialize::<_, _, cdr::CdrLe>(value, cdr::Infinite).expect("cdr")
    }

    fn of(sample: &PoseSample, frame: &str) -> (Header, [f64; 3], [f64; 4]) {
        let stamp = (
            (sample.stamp.0 / NANOSECONDS_PER_SECOND) as i32,
            (sample.stamp.0 % NANOSECONDS_PER_SECOND) as u32,
        );
        let position = sample.position_m.into();
        ((stamp, frame.to_owned()), position, sample.quaternion_xyzw)
    }

    #[test]
    fn messages_are_what_an_independent_encoder_makes() {
        for frame in ["", "map", "a frame of odd length"] {
            let pose = pose_stamped(frame, &sample(0)).expect("encode");
            assert_eq!(pose, theirs(&of(&sample(0), frame)));
            let header = header(sample(0).stamp, frame).expect("encode");
            assert_eq!(header, theirs(&of(&sample(0), frame).0));
            let transforms = [0, 1, 2].map(|k| Transform {
                parent: frame,
                child: "child",
                sample: sample(k),
            });
            let expected: Vec<_> = (0..3)
                .map(|k| {
                    let (header, position, rotation) = of(&sample(k), frame);
                    (header, "child".to_owned(), position, rotation)
                })
                .collect();
            let message = tf_message(&transforms).expect("encode");
            assert_eq!(message, theirs(&expected));
        }
        for names in [&["a", "elbow_2", "ab"][..], &["hip_x", "knee"], &[]] {
            for rate_rad_s in [Some(-2.5), None] {
                let joints = names.iter().enumerate().map(|(k, name)| JointState {
                    name,
                    angle_rad: 0.1 * k as f64,
                    rate_rad_s,
                });
                let joints: Vec<JointState> = joints.collect();
                let angles: Vec<f64> = joints.iter().map(|joint| joint.angle_rad).collect();
                let rates = vec![-2.5; if rate_rad_s.is_some() { names.len() } else { 0 }];
                let efforts: Vec<f64> = Vec::new();
                let header = of(&sample(0), "").0;
                let message = joint_state(sample(0).stamp, &joints).expect("encode");
                assert_eq!(message, theirs(&(header, names, angles, rates, efforts)));
            }
        }
        for text in ["", "a", "<robot/>"] {
            assert_eq!(string(text), theirs(&text));
        }
    }

    #[test]
    fn what_is_encoded_is_decoded_by_the_names_of_the_schemas() {
        let schema = RosMessage::PoseStamped.schema();
        let format = PoseFormat::of(&schema.name, "cdr").expect("known");
        let mut found = Vec::new();
        let bytes = pose_stamped("map", &sample(7)).expect("encode");
        format.decode(&bytes, &mut found).expect("decode");
        assert_eq!(found[0].stamp, Some(sample(7).stamp));
        assert_eq!(found[0].position_m, sample(7).position_m);
        let schema = RosMessage::Header.schema();
        let format = MarkFormat::of(&schema.name, "cdr").expect("known");
        let mark = format.decode(&header(Stamp(5), "bounce").expect("encode"));
        let mark = mark.expect("decode");
        assert_eq!(
            (mark.stamp, mark.event.as_deref()),
            (Some(Stamp(5)), Some("bounce"))
        );
    }

    #[test]
    fn seconds_that_do_not_fit_are_refused() {
        let past = (1i64 << 31) * NANOSECONDS_PER_SECOND;
        assert_eq!(header(Stamp(past), ""), Err(EncodeError::RosStamp(past)));
        assert!(header(Stamp(past - 1), "").is_ok());
    }
}
