use std::path::Path;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use proptest::prelude::*;

mod assumed;
mod formats;

use super::*;
use crate::motion::{Holds, LengthUnit, PoseSample};

fn read(text: &str, options: &TableOptions) -> Result<PoseTable, String> {
    read_table(Path::new("poses.csv"), text, options).map_err(|error| error.to_string())
}

fn plainly(text: &str) -> PoseTable {
    read(text, &TableOptions::default()).unwrap_or_else(|error| panic!("{text}\n{error}"))
}

fn refused(text: &str, options: &TableOptions) -> String {
    read(text, options).expect_err(text)
}

/// The pose that all the tables below have twice, 10 ms apart: at (1, 2, 3) m.
fn assert_is_the_pose(samples: &[PoseSample], what: &str) {
    assert_eq!(samples.len(), 2, "{what}");
    for (sample, ns) in samples.iter().zip([500_000_000, 510_000_000]) {
        assert_eq!(sample.stamp.0, ns, "{what}");
        let off = sample.position_m - Vector3::new(1.0, 2.0, 3.0);
        assert!(off.norm() < 1e-12, "{what}: {sample:?}");
        for (part, expected) in sample.quaternion_xyzw.iter().zip([0.1, 0.5, -0.7, 0.5]) {
            assert!((part - expected).abs() < 1e-12, "{what}: {sample:?}");
        }
    }
}

#[test]
fn the_same_poses_are_read_from_every_kind_of_table() {
    for (kind, text) in [
        (
            "a table, commas",
            "t,x,y,z,qw,qx,qy,qz\n0.5,1,2,3,0.5,0.1,0.5,-0.7\n0.51,1,2,3,0.5,0.1,0.5,-0.7\n",
        ),
        (
            "a table, semicolons",
            "qz;z_mm;qx;time_ms;y_mm;qy;x_mm;qw\n-0,7;3000;0,1;500;2000;0,5;1000;0,5\n-0,7;3000;0,1;510,0;2000;0,5;1000;0,5\n",
        ),
        (
            "EuRoC, commas",
            "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],q_RS_z [],v_RS_R_x [m s^-1]\n\
             500000000,1,2,3,0.5,0.1,0.5,-0.7,9\n510000000,1,2,3,0.5,0.1,0.5,-0.7,9\n",
        ),
        (
            "TUM, blanks",
            "# timestamp tx ty tz qx qy qz qw\n0.5 1 2 3 0.1 0.5 -0.7 0.5\n0.51 1 2 3 0.1 0.5 -0.7 0.5\n",
        ),
        (
            "TUM, blanks",
            "0.5 1  2 3 0.1 0.5 -0.7 0.5\n0.51 1  2 3 0.1 0.5 -0.7 0.5",
        ),
        (
            "a table, commas",
            "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.pose.position.x,field.pose.position.y,field.pose.position.z,field.pose.orientation.x,field.pose.orientation.y,field.pose.orientation.z,field.pose.orientation.w\n\
             7000000000,1,500000000,map,1,2,3,0.1,0.5,-0.7,0.5\n7010000000,2,510000000,map,1,2,3,0.1,0.5,-0.7,0.5\n",
        ),
        (
            "a table, tabs",
            "header.stamp.sec\theader.stamp.nanosec\tpose.position.x\tpose.position.y\tpose.position.z\tpose.orientation.x\tpose.orientation.y\tpose.orientation.z\tpose.orientation.w\n\
             0\t500000000\t1\t2\t3\t0.1\t0.5\t-0.7\t0.5\n0\t510000000\t1\t2\t3\t0.1\t0.5\t-0.7\t0.5\n",
        ),
    ] {
        let table = plainly(text);
        assert_eq!(table.kind, kind, "{text}");
        assert_eq!(table.bodies.len(), 1);
        assert_is_the_pose(&table.bodies[0].samples, text);
    }
}

const MOTIVE: &str = "Format Version,1.23,Take Name,a take,Capture Frame Rate,100.000000,Export Frame Rate,100.000000,Rotation Type,Quaternion,Length Units,Millimeters,Coordinate Space,Global\n\
\n\
,,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Marker,Marker,Marker,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body\n\
,,Cup,Cup,Cup,Cup,Cup,Cup,Cup,Cup,m1,m1,m1,Hand,Hand,Hand,Hand,Hand,Hand,Hand,Hand\n\
,,1,1,1,1,1,1,1,1,2,2,2,3,3,3,3,3,3,3,3\n\
,,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Mean Marker Error,Position,Position,Position,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Mean Marker Error\n\
Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,,X,Y,Z,X,Y,Z,W,X,Y,Z,\n\
0,0.500000,0,0,0,1,1000,3000,-2000,0.1,1,1,1,0,0,0,1,0,0,0,0.1\n\
1,0.510000,0,0,0,1,1000,3000,-2000,0.1,1,1,1,,,,,,,,\n";

#[test]
fn motives_bodies_come_with_their_names_and_z_up() {
    let table = plainly(MOTIVE);
    assert_eq!(table.kind, "Motive 1.23, commas");
    assert_eq!(
        (table.preset.name, table.length),
        ("motive-y-up", LengthUnit::Millimetre)
    );
    let [cup, marker, hand] = &table.bodies[..] else {
        panic!("{table:?}");
    };
    assert_eq!(cup.name.as_deref(), Some("Cup"));
    assert_eq!(
        (marker.name.as_deref(), marker.samples[0].holds),
        (Some("m1"), Holds::Position)
    );
    assert_eq!(
        (
            hand.name.as_deref(),
            hand.samples.len(),
            hand.unseen.count()
        ),
        (Some("Hand"), 1, 1)
    );
    let sample = &cup.samples[1];
    assert_eq!(sample.stamp.0, 510_000_000);
    assert!((sample.position_m - Vector3::new(1.0, 2.0, 3.0)).norm() < 1e-12);
    // The body's own y axis, which is up in Motive, is up.
    let [x, y, z, w] = sample.quaternion_xyzw;
    let turned = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    assert!((turned * Vector3::y() - Vector3::z()).norm() < 1e-12);
    let said = table.notes.join("\n");
    assert!(
        said.contains("y up") && said.contains("2 of markers"),
        "{said}"
    );
    let error = refused(
        &MOTIVE.replace("Quaternion", "Sideways"),
        &TableOptions::default(),
    );
    assert!(
        error.starts_with("poses.csv:1: Rotation Type is Sideways"),
        "{error}"
    );
}

const VICON: &str = "Objects\n100\n,,Cup:Cup,,,,,,,Global Angle Hand:Wrist,,,,,,\n\
Frame,Sub Frame,RX,RY,RZ,RW,TX,TY,TZ,RX,RY,RZ,RW,TX,TY,TZ\n\
,,,,,,mm,mm,mm,,,,,mm,mm,mm\n\
51,0,0.1,0.5,-0.7,0.5,1000,2000,3000,0,0,0,1,0,0,0\n\
52,0,0.1,0.5,-0.7,0.5,1000,2000,3000,,,,,,,\n\
\n\
Trajectories\n100\n,,m1,,\nFrame,Sub Frame,X,Y,Z\n,,mm,mm,mm\n51,0,1,2,3\n";

#[test]
fn vicons_frames_are_times_at_the_rate_of_the_section() {
    let table = plainly(VICON);
    assert_eq!(
        (table.kind.as_str(), table.preset.name),
        ("Vicon Objects, commas", "vicon")
    );
    let [cup, hand] = &table.bodies[..] else {
        panic!("{table:?}");
    };
    assert_eq!(cup.name.as_deref(), Some("Cup"));
    assert_eq!((hand.samples.len(), hand.unseen.count()), (1, 1));
    // Frame 51 is the first: its time is that of all files of the capture.
    let mut samples = cup.samples.clone();
    for sample in &mut samples {
        sample.stamp.0 -= 10_000_000;
    }
    assert_is_the_pose(&samples, "Vicon");
    assert_eq!(table.zero.map(|zero| zero.0), Some(510_000_000));
    assert!(
        table.notes.join("\n").contains("section Trajectories"),
        "{:?}",
        table.notes
    );
    // Trajectories first, and three angles, whose meaning is to be said.
    let (objects, others) = VICON.split_once("\n\n").expect("two sections");
    assert_eq!(
        plainly(&format!("{others}\n{objects}\n")).bodies[0]
            .samples
            .len(),
        2
    );
    let nexus = "Segments\n200\n,,Cup,,,,,\nFrame,Sub Frame,RX,RY,RZ,TX,TY,TZ\n,,deg,deg,deg,mm,mm,mm\n\
                 1,0,0,0,90,1000,0,0\n2,0,0,0,90,1000,0,0\n";
    let error = refused(nexus, &TableOptions::default());
    assert!(
        error.contains("poses.csv:6") && error.contains("expected --rotation"),
        "{error}"
    );
    for turn in ["vector", "euler-xyz", "rpy"] {
        let options = TableOptions {
            turn: Turn::named(turn),
            ..TableOptions::default()
        };
        let sample = read(nexus, &options).unwrap().bodies[0].samples[1];
        assert_eq!(sample.stamp.0, 10_000_000);
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let [x, y, z, w] = sample.quaternion_xyzw;
        assert!(x == 0.0 && y == 0.0 && (z - half).abs() < 1e-12 && (w - half).abs() < 1e-12);
    }
    let error = refused(
        "Devices\n100\n,,m1,,\nFrame,Sub Frame,X,Y,Z\n,,mm,mm,mm\n51,0,1,2,3\n",
        &TableOptions::default(),
    );
    assert!(
        error.contains("no section Objects, Segments or Trajectories"),
        "{error}"
    );
}

#[test]
fn markers_without_rigid_bodies_are_points() {
    let motive = "Format Version,1.23,Rotation Type,XYZ,Length Units,Meters\n\n,,Marker,Marker,Marker\n,,Cap,Cap,Cap\n,,7,7,7\n\
                  ,,Position,Position,Position\nFrame,Time (Seconds),X,Y,Z\n0,0.00,1,3,-2\n1,0.01,1,3,-2\n";
    let vicon = "Trajectories\n100\n,,Hat:Cap,,,Hat:Rim,,\nFrame,Sub Frame,X,Y,Z,X,Y,Z\n,,mm,mm,mm,mm,mm,mm\n\
                 1,0,1000,2000,3000,,,\n2,0,1000,2000,3000,1,2,3\n";
    for (text, names) in [(motive, &["Cap"][..]), (vicon, &["Hat:Cap", "Hat:Rim"])] {
        let table = plainly(text);
        let found: Vec<&str> = table
            .bodies
            .iter()
            .flat_map(|of| of.name.as_deref())
            .collect();
        assert_eq!(found, names, "{text}");
        for sample in &table.bodies[0].samples {
            assert_eq!(sample.holds, Holds::Position, "{text}");
            let off = sample.position_m - Vector3::new(1.0, 2.0, 3.0);
            assert!(off.norm() < 1e-12, "{text}: {sample:?}");
        }
        assert_eq!(table.bodies[0].samples.len(), 2, "{text}");
        assert!(
            table.notes.iter().any(|of| of.contains("points are taken")),
            "{text}"
        );
    }
}

#[test]
fn bodies_in_turn_are_told_by_name() {
    let table = plainly(
        "t,body,x,y,z,qx,qy,qz,qw\n0,a,1,2,3,0,0,0,1\n0,b,4,5,6,0,0,0,1\n0.01,a,1,2,3,0,0,0,1\n0.01,b,nan,,,0,0,0,1\n",
    );
    let counts: Vec<_> = table
        .bodies
        .iter()
        .map(|body| {
            (
                body.name.as_deref(),
                body.samples.len(),
                body.unseen.count(),
            )
        })
        .collect();
    assert_eq!(counts, [(Some("a"), 2, 0), (Some("b"), 1, 1)]);
}

#[test]
fn what_is_asked_for_goes_before_what_the_file_says() {
    let text = "a,b,c,d,e,f,g,h,i\n1,9,1,2,3,0.1,0.5,-0.7,0.5\n2,9,1,2,3,0.1,0.5,-0.7,0.5\n";
    let options = TableOptions {
        columns: Some("frame,-,x,y,z,qx,qy,qz,qw".to_owned()),
        rate_hz: Some(100.0),
        ..TableOptions::default()
    };
    let mut samples = read(text, &options).unwrap().bodies.remove(0).samples;
    for sample in &mut samples {
        sample.stamp.0 += 490_000_000;
    }
    assert_is_the_pose(&samples, "by flags");
    let numbered = "t,x,y,z,q0,q1,q2,q3\n0.5,1,2,3,0.1,0.5,-0.7,0.5\n0.51,1,2,3,0.1,0.5,-0.7,0.5\n";
    let options = TableOptions {
        quaternion: Some(QuaternionOrder::Xyzw),
        ..TableOptions::default()
    };
    assert_is_the_pose(&read(numbered, &options).unwrap().bodies[0].samples, "xyzw");
    let guessed = plainly(numbered);
    assert_eq!(
        guessed.bodies[0].samples[0].quaternion_xyzw,
        [0.5, -0.7, 0.5, 0.1]
    );
    assert!(guessed.notes[0].contains("numbered"), "{:?}", guessed.notes);
}

#[test]
fn units_of_times_are_told_by_their_intervals_and_that_is_said() {
    for (unit, per_s) in [("s", 1.0), ("ms", 1e3), ("µs", 1e6), ("ns", 1e9)] {
        for rate_hz in [30.0, 148.3, 2000.0] {
            let rows: String = (1..20)
                .map(|row| format!("{},1,2,3,0,0,0,1\n", f64::from(row) / rate_hz * per_s))
                .collect();
            let table = plainly(&format!("t,x,y,z,qx,qy,qz,qw\n{rows}"));
            let said = table.notes.join("\n");
            assert!(said.contains(&format!("taken for {unit}:")), "{said}");
            let last = table.bodies[0].samples[18].stamp.0;
            assert!(
                (last as f64 - 19e9 / rate_hz).abs() <= 1.0,
                "{unit} {rate_hz} {last}"
            );
        }
    }
}

#[test]
fn what_is_no_table_of_poses_is_said_with_its_line() {
    let none = TableOptions::default();
    for (text, message) in [
        ("", "poses.csv: no row of numbers"),
        ("hello\nworld\n", "no row of numbers"),
        (
            "t,x,y,z,qx,qy\n0,1,2,3,0,0\n",
            "poses.csv:1: not all columns for an orientation",
        ),
        (
            "t,a,b,c,qx,qy,qz,qw\n0,1,2,3,0,0,0,1\n",
            "no columns for a position",
        ),
        (
            "t,x,y,z,x_mm,qx,qy,qz,qw\n0,1,2,3,1,0,0,0,1\n",
            "several columns for x: x, x_mm",
        ),
        (
            "t,x,y,z,qx,qy,qz,qw\n1,1,2,3,0,0,0,1\n2,1,2,3,0,0,0,1\n",
            "go up by 1",
        ),
        (
            "frame,x,y,z,qx,qy,qz,qw\n1,1,2,3,0,0,0,1\n",
            "expected --rate HZ",
        ),
        ("x,y,z,qx,qy,qz,qw\n1,2,3,0,0,0,1\n", "no column of times"),
        (
            "t,x,y,z,qx,qy,qz,qw\n0,1,2,3,0,0,0,1\n0.01,1,2,here,0,0,0,1\n",
            "poses.csv:3: column 4: \"here\"",
        ),
        (
            "t,x,y,z,qx,qy,qz,qw\n0,1,2,3,0,0,0,1\n0.01,1,2,3\n0.02,1,2,3,0,0,0,1\n",
            "poses.csv:3: 4 cells",
        ),
        (
            "t,x,y,z,qx,qy,qz,qw\n-0.01,1,2,3,0,0,0,1\n0,1,2,3,0,0,0,1\n",
            "a time of -0.01",
        ),
        (
            "t,x,y,z,qx,qy,qz,qw,k\n0,1,2,3,0,0,0,1\n",
            "9 column names, and 8 numbers in line 2",
        ),
        ("0,1,2,3,0,0,0,1,5\n", "9 columns without names"),
        (
            "t,x,y,z,qx,qy,qz,qw\n0,,2,3,0,0,0,1\n0.01,1,,3,0,0,0,1\n",
            "no row with a pose",
        ),
    ] {
        let error = refused(text, &none);
        assert!(error.contains(message), "{text}\n{error}");
    }
}

#[test]
fn a_last_line_that_is_cut_off_is_lost_and_said() {
    let table = plainly("t,x,y,z,qx,qy,qz,qw\n0,1,2,3,0,0,0,1\n0.01,1,2,3,0,0,0,1\n0.02,1,2");
    assert_eq!(table.bodies[0].samples.len(), 2);
    assert_eq!(table.lost, ["line 4: the last, which is cut off"]);
}

proptest! {
    #[test]
    fn any_text_is_answered(
        head in prop::sample::select(vec!["", MOTIVE, VICON, "t,x,y,z,qx,qy,qz,qw\n"]),
        kept in 0_usize..2000,
        text in "[-+0-9a-zA-Z_.,;:\t \n\r#%\"'|\\[\\]µ]{0,160}",
        rate_hz in prop::option::of(0.1..1e6),
    ) {
        let mut kept = kept.min(head.len());
        while !head.is_char_boundary(kept) {
            kept -= 1;
        }
        let options = TableOptions { rate_hz, ..TableOptions::default() };
        if let Ok(table) = read(&format!("{}{text}", &head[..kept]), &options) {
            for body in &table.bodies {
                for sample in &body.samples {
                    prop_assert!(sample.position_m.iter().all(|of| of.is_finite()));
                    prop_assert!(sample.stamp.0 >= 0);
                }
            }
        }
    }

    #[test]
    fn poses_in_any_order_of_columns_are_read_again(
        order in Just((0..8).collect::<Vec<usize>>()).prop_shuffle(),
        separator in prop::sample::select(vec![',', ';', '\t', ' ', '|']),
        rows in prop::collection::vec(prop::array::uniform7(1.5..10.0), 2..20),
    ) {
        let names = ["t", "x", "y", "z", "qx", "qy", "qz", "qw"];
        let line = |cells: Vec<String>| {
            let cells: Vec<&str> = order.iter().map(|at| cells[*at].as_str()).collect();
            cells.join(&separator.to_string()) + "\n"
        };
        let mut text = line(names.iter().map(|name| (*name).to_owned()).collect());
        for (index, row) in rows.iter().enumerate() {
            let time = format!("0.{:09}", 7_000_000 * index);
            let cells = std::iter::once(time).chain(row.iter().map(f64::to_string));
            text += &line(cells.collect());
        }
        let table = plainly(&text);
        let samples = &table.bodies[0].samples;
        prop_assert_eq!(samples.len(), rows.len());
        for (index, (sample, row)) in samples.iter().zip(&rows).enumerate() {
            prop_assert_eq!(sample.stamp.0, 7_000_000 * index as i64);
            prop_assert_eq!(sample.position_m.as_slice(), &row[..3]);
            prop_assert_eq!(&sample.quaternion_xyzw[..], &row[3..]);
        }
    }
}
