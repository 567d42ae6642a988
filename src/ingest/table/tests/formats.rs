//! Formats of other programs, written here as they write them.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::{assert_is_the_pose, plainly, read, refused};
use crate::ingest::table::{PoseTable, TableOptions, Turn};
use crate::motion::Holds;

/// The orientation of the pose, as a matrix.
fn matrix() -> Matrix3<f64> {
    let turned = UnitQuaternion::new_normalize(Quaternion::new(0.5, 0.1, 0.5, -0.7));
    turned.to_rotation_matrix().into_inner()
}

fn roll_pitch_yaw() -> [f64; 3] {
    let turned = UnitQuaternion::new_normalize(Quaternion::new(0.5, 0.1, 0.5, -0.7));
    let (roll, pitch, yaw) = turned.euler_angles();
    [roll, pitch, yaw]
}

fn joined(numbers: impl IntoIterator<Item = f64>, separator: &str) -> String {
    let numbers: Vec<String> = numbers.into_iter().map(|of| of.to_string()).collect();
    numbers.join(separator)
}

/// Entries of a matrix row by row, with the position in its fourth column.
fn pose_rows() -> Vec<f64> {
    let (m, p) = (matrix(), [1.0, 2.0, 3.0]);
    (0..3)
        .flat_map(|row| [m[(row, 0)], m[(row, 1)], m[(row, 2)], p[row]])
        .collect()
}

/// The samples of the first body, whose first time is half a second.
fn assert_has_the_pose(table: &PoseTable, what: &str) {
    let mut samples = table.bodies[0].samples.clone();
    let first = samples[0].stamp.0;
    for sample in &mut samples {
        sample.stamp.0 += 500_000_000 - first;
        // Either sign is the same orientation.
        if sample.quaternion_xyzw[3] < 0.0 {
            sample.quaternion_xyzw = sample.quaternion_xyzw.map(|part| -part);
        }
    }
    assert_is_the_pose(&samples, what);
}

fn with_rate(rate_hz: f64) -> TableOptions {
    TableOptions {
        rate_hz: Some(rate_hz),
        ..TableOptions::default()
    }
}

/// A 6D export: a body that is seen, one that is not in its second row, and a cell that is empty at the end of each line.
fn qualisys_6d() -> String {
    let m = matrix();
    let [roll, pitch, yaw] = roll_pitch_yaw().map(f64::to_degrees);
    let by_columns = joined(m.iter().copied(), "\t");
    let body = format!("1000.0\t2000.0\t3000.0\t{roll}\t{pitch}\t{yaw}\t0.5\t{by_columns}");
    let zeros = joined([0.0; 6], "\t");
    let nothing = format!("{zeros}\t-1\t{}", joined([0.0; 9], "\t"));
    let names = |name: &str| {
        let entries: Vec<String> = (0..9).map(|at| format!("Rot[{at}]")).collect();
        format!(
            "{name} X\tY\tZ\tRoll\tPitch\tYaw\tResidual\t{}",
            entries.join("\t")
        )
    };
    format!(
        "NO_OF_FRAMES\t2\nNO_OF_CAMERAS\t4\nNO_OF_BODIES\t2\nFREQUENCY\t100\nDESCRIPTION\t--\n\
         TIME_STAMP\t2020-01-22, 17:47:17\t22107.99\nDATA_INCLUDED\t6D\nEVENT\tbounce\t52\t0.51\nBODY_NAMES\tCup\tHand\n\
         Frame\tTime\t{}\t{}\t\n51\t0.50000\t{body}\t{body}\t\n52\t0.51000\t{body}\t{nothing}\t\n",
        names("Cup"),
        names("Hand")
    )
}

#[test]
fn bodies_of_qualisys_are_read_by_their_matrices_with_events_as_marks() {
    let text = qualisys_6d();
    let table = plainly(&text);
    assert_eq!(table.kind, "Qualisys 6D, tabs");
    assert_has_the_pose(&table, &text);
    let names: Vec<_> = table
        .bodies
        .iter()
        .map(|of| of.name.as_deref().unwrap())
        .collect();
    assert_eq!(names, ["Cup", "Hand"]);
    let hand = &table.bodies[1];
    assert_eq!((hand.samples.len(), hand.unseen.count()), (1, 1));
    assert_eq!(table.marks.len(), 1);
    assert_eq!(
        (table.marks[0].0.as_str(), table.marks[0].1.0),
        ("bounce", 520_000_000)
    );
    // Without the line of names there are as many columns.
    let nameless: Vec<&str> = text
        .lines()
        .filter(|line| !line.starts_with("Frame"))
        .collect();
    assert_has_the_pose(&plainly(&(nameless.join("\n") + "\n")), "nameless");
    // Without a matrix, angles are in degrees, and roll, pitch, yaw as Qualisys has them.
    let angles: Vec<String> = text
        .lines()
        .map(|line| {
            let cells: Vec<&str> = line.split('\t').collect();
            let is_row = cells.len() > 20;
            if is_row {
                cells[..9].join("\t") + "\t"
            } else {
                line.replace("\tHand", "")
            }
        })
        .collect();
    assert_has_the_pose(&plainly(&(angles.join("\n") + "\n")), "angles");
}

#[test]
fn markers_of_qualisys_and_trc_are_points_and_zeros_are_none() {
    let qualisys = "NO_OF_FRAMES\t3\nFREQUENCY\t100\nDATA_INCLUDED\t3D\nMARKER_NAMES\tCap\t\nFrame\tTime\tCap X\tCap Y\tCap Z\t X\t Y\t Z\t\n\
                    1\t0.0\t0.000\t0.000\t0.000\t1\t1\t1\t\n2\t0.01\t1000\t2000\t3000\t1\t1\t1\t\n3\t0.02\t1000\t2000\t3000\t0.000\t0.000\t0.000\t\n";
    let table = plainly(qualisys);
    let counts: Vec<_> = table
        .bodies
        .iter()
        .map(|of| {
            (
                of.name.as_deref().unwrap(),
                of.samples.len(),
                of.unseen.count(),
            )
        })
        .collect();
    assert_eq!(counts, [("Cap", 2, 1), ("unlabeled 2", 2, 1)]);
    let sample = &table.bodies[0].samples[0];
    assert_eq!(
        (sample.holds, sample.stamp.0),
        (Holds::Position, 20_000_000)
    );
    assert!((sample.position_m - Vector3::new(1.0, 2.0, 3.0)).norm() < 1e-12);
    let trc = "PathFileType\t4\t(X/Y/Z)\ttoss.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n\
               100.00\t100.00\t2\t2\tmm\t100.00\t1\t2\nFrame#\tTime\tCap\t\t\tRim\t\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\t\n\n\
               1\t0.500\t1000\t3000\t-2000\t\t\t\t\n2\t0.510\t1000\t3000\t-2000\t4\t5\t6\t\n";
    let table = plainly(trc);
    assert_eq!(
        (table.kind.as_str(), table.preset.name),
        ("TRC, tabs", "trc")
    );
    let [cap, rim] = &table.bodies[..] else {
        panic!("{table:?}");
    };
    assert_eq!(
        (cap.name.as_deref(), rim.name.as_deref()),
        (Some("Cap"), Some("Rim"))
    );
    assert_eq!(
        (cap.samples.len(), rim.samples.len(), rim.unseen.count()),
        (2, 1, 1)
    );
    assert_eq!(cap.samples[0].stamp.0, 500_000_000);
    assert!((cap.samples[0].position_m - Vector3::new(1.0, 2.0, 3.0)).norm() < 1e-12);
}

#[test]
fn rows_of_matrices_are_read_with_and_without_times() {
    let row = joined(pose_rows(), " ");
    let whole = format!("{row} 0 0 0 1");
    let by_columns = {
        let m = matrix();
        let columns = (0..3).flat_map(|at| [m[(0, at)], m[(1, at)], m[(2, at)], 0.0]);
        joined(columns.chain([1.0, 2.0, 3.0, 1.0]), " ")
    };
    for (text, options) in [
        (format!("{row}\n{row}\n"), with_rate(100.0)),
        (format!("{whole}\n{whole}\n"), with_rate(100.0)),
        (format!("{by_columns}\n{by_columns}\n"), with_rate(100.0)),
        (format!("0.5 {row}\n0.51 {row}\n"), TableOptions::default()),
        (
            format!("0.5 {by_columns}\n0.51 {by_columns}\n"),
            TableOptions::default(),
        ),
    ] {
        let table = read(&text, &options).unwrap_or_else(|error| panic!("{text}{error}"));
        assert_has_the_pose(&table, &text);
    }
    let error = refused(&format!("{row}\n{row}\n"), &TableOptions::default());
    assert!(error.contains("expected --rate HZ"), "{error}");
    // Twelve numbers of something else.
    let others = joined((1..13).map(f64::from), " ");
    let error = refused(&format!("{others}\n{others}\n"), &with_rate(100.0));
    assert!(error.contains("12 columns without names"), "{error}");
    // By names, counted from 0 and from 1.
    for base in [0, 1] {
        let names: Vec<String> = (0..12)
            .map(|at| format!("m{}{}", base + at / 4, base + at % 4))
            .collect();
        let row = joined(pose_rows(), ",");
        let text = format!("t,{}\n0.5,{row}\n0.51,{row}\n", names.join(","));
        assert_has_the_pose(&plainly(&text), &text);
    }
    let m = matrix();
    let entries = joined((0..9).map(|at| m[(at / 3, at % 3)]), ",");
    let text = format!(
        "t,x,y,z,R11,R12,R13,R21,R22,R23,R31,R32,R33\n0.5,1,2,3,{entries}\n0.51,1,2,3,{entries}\n"
    );
    assert_has_the_pose(&plainly(&text), &text);
}

#[test]
fn columns_of_ros_are_read_in_all_their_forms() {
    let pose = "1,2,3,0.1,0.5,-0.7,0.5";
    for text in [
        format!("#sec,nsec,x,y,z,qx,qy,qz,qw\n7,500000000,{pose}\n7,510000000,{pose}\n"),
        format!("1767607200,500000000,world,{pose}\n1767607200,510000000,world,{pose}\n"),
        format!(
            "1767607200,500000000,world,cup,{pose},0,0,0\n1767607200,510000000,world,cup,{pose},0,0,0\n"
        ),
        "rosbagTimestamp,header,seq,stamp,secs,nsecs,frame_id,pose,position,x,y,z,orientation,x,y,z,w\n\
             1767607209000000000,,0,,7,500000000,\"world\",,,1,2,3,,0.1,0.5,-0.7,0.5\n\
             1767607209200000000,,1,,7,510000000,\"world\",,,1,2,3,,0.1,0.5,-0.7,0.5\n"
            .to_owned(),
        format!(
            "__time,/cup/pose/position/x,/cup/pose/position/y,/cup/pose/position/z,/cup/pose/orientation/x,\
             /cup/pose/orientation/y,/cup/pose/orientation/z,/cup/pose/orientation/w\n7.5,{pose}\n7.51,{pose}\n"
        ),
    ] {
        assert_has_the_pose(&plainly(&text), &text);
    }
}

#[test]
fn quaternions_are_known_by_many_names() {
    for names in [
        "qi,qj,qk,qr",
        "i,j,k,real",
        "ox,oy,oz,ow",
        "rx,ry,rz,rw",
        "x,y,z,w",
        "RotX,RotY,RotZ,RotW",
        "quat_x,quat_y,quat_z,quat_w",
        "quat_i,quat_j,quat_k,quat_r",
    ] {
        let text = format!(
            "t,px,py,pz,{names}\n0.5,1,2,3,0.1,0.5,-0.7,0.5\n0.51,1,2,3,0.1,0.5,-0.7,0.5\n"
        );
        assert_has_the_pose(&plainly(&text), &text);
    }
    // Two of each letter: those beside the w are its.
    let text = "Time,X,Y,Z,w,x,y,z\n0.5,1,2,3,0.5,0.1,0.5,-0.7\n0.51,1,2,3,0.5,0.1,0.5,-0.7\n";
    let none = TableOptions::default();
    let error = refused(text, &none);
    assert!(error.contains("which x, y, z belong to w"), "{error}");
    let text = "Time,X,Y,Z,x,y,z,w\n0.5,1,2,3,0.1,0.5,-0.7,0.5\n0.51,1,2,3,0.1,0.5,-0.7,0.5\n";
    assert_has_the_pose(&plainly(text), text);
    // As pandas writes names that come again.
    let text = "t,x,y,z,x.1,y.1,z.1,w\n0.5,1,2,3,0.1,0.5,-0.7,0.5\n0.51,1,2,3,0.1,0.5,-0.7,0.5\n";
    assert_has_the_pose(&plainly(text), text);
    let error = refused("stamp,a0,a1,a2,a3,a4,a5\n0,1,2,3,0,0,0\n", &none);
    assert!(
        error.contains("names of columns that are not known: stamp, a0"),
        "{error}"
    );
    let error = refused("t,W,X,Y,Z\n0,1,0,0,0\n0.01,1,0,0,0\n", &none);
    assert!(
        error.contains("no columns for a position") && error.contains("taken for a quaternion"),
        "{error}"
    );
}

#[test]
fn angles_are_roll_pitch_yaw_by_name_or_what_is_said() {
    let angles = roll_pitch_yaw();
    let rad = joined(angles, ",");
    let deg = joined(angles.map(f64::to_degrees), ",");
    let text =
        |names: &str, row: &str| format!("t,x,y,z,{names}\n0.5,1,2,3,{row}\n0.51,1,2,3,{row}\n");
    for text in [
        text("roll [rad],pitch [rad],yaw [rad]", &rad),
        text("roll_deg,pitch_deg,yaw_deg", &deg),
        text("Roll (°),Pitch (°),Yaw (°)", &deg),
        text("phi [deg],theta [deg],psi [deg]", &deg),
    ] {
        let table = plainly(&text);
        assert_has_the_pose(&table, &text);
        assert!(
            table.notes.iter().any(|of| of.contains("angles are rpy")),
            "{:?}",
            table.notes
        );
        assert_eq!(table.against, [""; 0], "{text}");
    }
    let unnamed = text("rx,ry,rz", &deg);
    let error = refused(&unnamed, &TableOptions::default());
    assert!(
        error.contains("expected --rotation") && error.contains("rpy"),
        "{error}"
    );
    let options = TableOptions {
        turn: Turn::named("rpy"),
        ..TableOptions::default()
    };
    let table = read(&unnamed, &options).unwrap();
    assert_has_the_pose(&table, &unnamed);
    assert!(
        table
            .notes
            .iter()
            .any(|of| of.starts_with("angles are in deg")),
        "{:?}",
        table.notes
    );
}

#[test]
fn motives_angles_bones_and_markers_are_side_by_side() {
    let turned = UnitQuaternion::new_normalize(Quaternion::new(0.5, 0.1, 0.5, -0.7));
    // Rx·Ry·Rz is the transpose of Rz·Ry·Rx of the turn back, with the angles' signs turned.
    let (x, y, z) = turned.inverse().euler_angles();
    let angles = joined([x, y, z].map(|of: f64| -of.to_degrees()), ",");
    let head = |kind: &str, name: &str, count: usize| {
        let all = |of: &str| vec![of; count].join(",");
        (all(kind), all(name))
    };
    let (a, an) = head("Rigid Body", "Cup", 6);
    let (b, bn) = head("Bone", "Hips", 6);
    let (c, cn) = head("Marker", "Cup:Marker1", 3);
    let (d, dn) = head("Marker", "Ball", 3);
    let (e, en) = head("Marker", "Unlabeled 17", 3);
    let turn = [
        "Rotation", "Rotation", "Rotation", "Position", "Position", "Position",
    ]
    .join(",");
    let point = ["Position"; 3].join(",");
    let row = |frame: usize| {
        format!(
            "{frame},{:.3},{angles},1,2,3,{angles},1,2,3,9,9,9,4,5,6,7,7,7",
            0.5 + 0.01 * frame as f64
        )
    };
    let text = format!(
        "Format Version,1.23,Rotation Type,XYZ,Length Units,Meters,Coordinate Space,Global\n\n\
         ,Type,{a},{b},{c},{d},{e}\n,Name,{an},{bn},{cn},{dn},{en}\n,ID,{an},{bn},{cn},{dn},{en}\n\
         ,,{turn},{turn},{point},{point},{point}\nFrame,Time (Seconds),X,Y,Z,X,Y,Z,X,Y,Z,X,Y,Z,X,Y,Z,X,Y,Z,X,Y,Z\n{}\n{}\n",
        row(0),
        row(1)
    );
    let options = TableOptions {
        preset: crate::ingest::table::Preset::named("motive-z-up"),
        ..TableOptions::default()
    };
    let table = read(&text, &options).unwrap();
    assert_has_the_pose(&table, &text);
    let names: Vec<_> = table
        .bodies
        .iter()
        .map(|of| of.name.as_deref().unwrap())
        .collect();
    assert_eq!(names, ["Cup", "Hips", "Ball"]);
    assert_eq!(table.bodies[2].samples[0].holds, Holds::Position);
    assert!(
        table
            .notes
            .iter()
            .any(|of| of.contains("1 unlabeled markers")),
        "{:?}",
        table.notes
    );
}

#[test]
fn bodies_side_by_side_are_told_by_the_names_of_their_columns() {
    let text = "t,cup_x,cup_y,cup_z,cup_qx,cup_qy,cup_qz,cup_qw,ball_x,ball_y,ball_z\n\
                0.5,1,2,3,0.1,0.5,-0.7,0.5,7,8,9\n0.51,1,2,3,0.1,0.5,-0.7,0.5,,,\n";
    let table = plainly(text);
    assert_has_the_pose(&table, text);
    let [cup, ball] = &table.bodies[..] else {
        panic!("{table:?}");
    };
    assert_eq!(
        (cup.name.as_deref(), ball.name.as_deref()),
        (Some("cup"), Some("ball"))
    );
    assert_eq!(
        (
            ball.samples[0].holds,
            ball.samples.len(),
            ball.unseen.count()
        ),
        (Holds::Position, 1, 1)
    );
    // What else is in three columns beside the pose of nobody in particular is not read.
    let table = plainly(
        "t,x,y,z,qx,qy,qz,qw,goal_x,goal_y,goal_z\n0,1,2,3,0,0,0,1,7,8,9\n0.01,1,2,3,0,0,0,1,7,8,9\n",
    );
    assert_eq!(table.bodies.len(), 1);
    assert!(
        table.notes.iter().any(|of| of.contains("not read: goal_x")),
        "{:?}",
        table.notes
    );
}

#[test]
fn units_and_owners_may_stand_in_lines_of_their_own() {
    let pose = "1000,2000,3000,0.1,0.5,-0.7,0.5";
    for text in [
        format!("t,x,y,z,qx,qy,qz,qw\ns,mm,mm,mm,,,,\n0.5,{pose}\n0.51,{pose}\n"),
        format!("# Units: mm\nt,x,y,z,qx,qy,qz,qw\n0.5,{pose}\n0.51,{pose}\n"),
        format!("# Units: mm\ntime,position[0],position[1],position[2],qx,qy,qz,qw\n0.5,{pose}\n0.51,{pose}\n"),
        "Frame,State,Q0,Qx,Qy,Qz,Tx (mm),Ty (mm),Tz (mm),time\n1,OK,0.5,0.1,0.5,-0.7,1000,2000,3000,0.5\n2,OK,0.5,0.1,0.5,-0.7,1000,2000,3000,0.51\n".to_owned(),
    ] {
        assert_has_the_pose(&plainly(&text), &text);
    }
    let text =
        "coords,cup,cup,cup,rim,rim,rim\ntime,x,y,z,x,y,z\n0.5,1,2,3,4,5,6\n0.51,1,2,3,4,5,6\n";
    let names: Vec<_> = plainly(text)
        .bodies
        .into_iter()
        .map(|of| of.name.unwrap())
        .collect();
    assert_eq!(names, ["cup", "rim"]);
    // Robots' A, B, C are an orientation.
    let table = plainly("t,X,Y,Z,A,B,C\n0,1,2,3,0,0,0\n0.01,1,2,3,0,0,0\n");
    assert!(
        table
            .against
            .iter()
            .any(|of| of.contains("are not read: A, B, C")),
        "{:?}",
        table.against
    );
    // A number for each row names no bodies.
    let rows: String = (0..9)
        .map(|row| format!("{row},{},1,2,3,0,0,0,1\n", 0.01 * f64::from(row)))
        .collect();
    assert_eq!(
        plainly(&format!("id,t,x,y,z,qx,qy,qz,qw\n{rows}"))
            .bodies
            .len(),
        1
    );
}
