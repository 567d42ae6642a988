//! What a table's reader takes for granted, and says.

use super::{plainly, read, refused};
use crate::ingest::table::{PoseTable, QuaternionOrder, TableOptions, TimeUnit};

const HEAD: &str = "t,x,y,z,qx,qy,qz,qw\n";

/// A table of so many rows with times of a text each, which moves.
fn timed(time: impl Fn(usize) -> String, count: usize) -> String {
    let row = |index: usize| {
        format!(
            "{},{},2,3,0.1,0.5,-0.7,0.5\n",
            time(index),
            1.0 + 0.001 * index as f64
        )
    };
    let rows: String = (0..count).map(row).collect();
    format!("{HEAD}{rows}")
}

fn span_ns(table: &PoseTable) -> i64 {
    let samples = &table.bodies[0].samples;
    samples[samples.len() - 1].stamp.0 - samples[0].stamp.0
}

fn says(lines: &[String], piece: &str) -> bool {
    lines.iter().any(|line| line.contains(piece))
}

#[test]
fn clocks_of_many_kinds_give_the_same_times() {
    // 101 rows at 120 Hz, exactly 1/1.2 s.
    let at_ns = |index: usize| index as u64 * 8_333_333;
    let of_day = |index: usize| {
        let ns = at_ns(index) + 500_000_000;
        format!(
            "23:59:{:02}.{:09}",
            59 + ns / 1_000_000_000,
            ns % 1_000_000_000
        )
    };
    let midnight = |index: usize| {
        let text = of_day(index);
        match text.strip_prefix("23:59:60") {
            Some(rest) => format!("00:00:00{rest}"),
            None => text,
        }
    };
    type Time<'a> = &'a dyn Fn(usize) -> String;
    let cases: [(&str, Time, &str); 8] = [
        (
            "ISO",
            &|i| format!("2026-01-05T10:00:00.{:09}Z", at_ns(i)),
            "dates with times of day",
        ),
        ("times of day", &midnight, "times of day"),
        (
            "s since 1970",
            &|i| format!("1767607200.{:09}", at_ns(i)),
            "s since 1970",
        ),
        (
            "ms since 1970",
            &|i| format!("{}", 1_767_607_200_000.0 + at_ns(i) as f64 * 1e-6),
            "ms since 1970",
        ),
        (
            "ns since 1970",
            &|i| format!("{}", 1_767_607_200_000_000_000 + at_ns(i)),
            "ns since 1970",
        ),
        (
            ".NET",
            &|i| format!("{}", 638_000_000_000_000_000 + at_ns(i) / 100),
            ".NET",
        ),
        (
            "Windows",
            &|i| format!("{}", 134_000_000_000_000_000 + at_ns(i) / 100),
            "Windows",
        ),
        (
            "ms",
            &|i| format!("{}", at_ns(i) as f64 * 1e-6),
            "taken for ms",
        ),
    ];
    for (what, time, said) in cases {
        let text = timed(time, 101);
        let table = plainly(&text);
        assert!(
            (span_ns(&table) - 833_333_300).abs() < 200_000,
            "{what}: {}",
            span_ns(&table)
        );
        assert!(says(&table.notes, said), "{what}: {:?}", table.notes);
        assert_eq!(table.against, [""; 0], "{what}");
        assert_eq!(table.bodies[0].against, [""; 0], "{what}");
    }
}

#[test]
fn a_unit_of_times_that_nothing_tells_is_doubted() {
    // Ticks of a clock that began at some time: microseconds of a slow tracker as well.
    let ticks = timed(|i| format!("{}", 9_514_127_732_u64 + 83_333 * i as u64), 50);
    let table = plainly(&ticks);
    assert!(
        says(&table.against, "--time-unit") && says(&table.against, "100ns at 120.0 Hz"),
        "{:?}",
        table.against
    );
    let options = TableOptions {
        time_unit: Some(TimeUnit::Tick),
        ..TableOptions::default()
    };
    let table = read(&ticks, &options).unwrap();
    assert_eq!((span_ns(&table), table.against.len()), (49 * 8_333_300, 0));
    // TUM is seconds, however slow.
    let tum: String = (0..9)
        .map(|i| format!("{} {i} 2 3 0 0 0 1\n", 1.4 * f64::from(i)))
        .collect();
    assert_eq!(span_ns(&plainly(&tum)), 11_200_000_000);
    // What is stated is doubted by its size.
    let stated = timed(|i| format!("{}", 7_607_200 + 8_333 * i as u64), 20).replace("t,x", "t_s,x");
    let table = plainly(&stated);
    assert!(
        says(&table.against, "times in s are 0.000 rows a second"),
        "{:?}",
        table.against
    );
}

#[test]
fn formats_decide_the_order_of_quaternions_and_sizes_do_not() {
    let rows = |separator: &str| -> String {
        let row = |i: u64| {
            let time = (1_403_636_580_838_555_574_u64 + 5_000_000 * i).to_string();
            [time.as_str(), "1", "2", "3", "0.1", "0.5", "-0.7", "0.5"].join(separator) + "\n"
        };
        (0..5).map(row).collect()
    };
    let first = |table: &PoseTable| table.bodies[0].samples[0].quaternion_xyzw;
    let blanks = plainly(&rows(" "));
    assert_eq!(first(&blanks), [0.1, 0.5, -0.7, 0.5]);
    assert_eq!(span_ns(&blanks), 20_000_000);
    let commas = plainly(&rows(","));
    assert_eq!(first(&commas), [0.5, -0.7, 0.5, 0.1]);
    assert_eq!((blanks.against.len(), commas.against.len()), (0, 0));
    // Neither of them.
    let neither = "0.00,1,2,3,0.1,0.5,-0.7,0.5\n0.01,1,2,3,0.1,0.5,-0.7,0.5\n";
    assert!(says(&plainly(neither).against, "--quaternion"));
    let options = TableOptions {
        quaternion: Some(QuaternionOrder::Wxyz),
        ..TableOptions::default()
    };
    let said = read(neither, &options).unwrap();
    assert_eq!(
        (first(&said), said.against.len()),
        ([0.5, -0.7, 0.5, 0.1], 0)
    );
}

#[test]
fn what_was_not_seen_is_told_by_one_vocabulary() {
    let row = |index: usize, cells: &str| format!("{:.2},{cells}\n", 0.01 * index as f64);
    let seen = |index: usize| format!("1.{index:03},2,3,0.1,0.5,-0.7,0.5");
    for (nothing, reason) in [
        (",,,,,,", "empty cells"),
        ("NA,NA,NA,NA,NA,NA,NA", "words for nothing"),
        ("-nan(ind),-nan(ind),-nan(ind),1,0,0,0", "words for nothing"),
        ("inf,inf,inf,0.1,0.5,-0.7,0.5", "words for nothing"),
        (
            "9999999,9999999,9999999,9999999,9999999,9999999,9999999",
            "stands for nothing",
        ),
        ("0,0,0,0,0,0,1", "very origin"),
        ("0,0,0,0.1,0.5,-0.7,0.5", "very origin"),
    ] {
        // Before anything is seen, and between.
        let rows = (0..20).map(|index| match index {
            0 | 1 | 9 => row(index, nothing),
            index => row(index, &seen(index)),
        });
        let table = plainly(&format!("{HEAD}{}", rows.collect::<String>()));
        let body = &table.bodies[0];
        assert_eq!(
            (body.samples.len(), body.unseen.count()),
            (17, 3),
            "{nothing}"
        );
        assert!(
            body.unseen.words().unwrap().contains(reason),
            "{nothing}: {:?}",
            body.unseen
        );
    }
    for (name, nothing, reason) in [
        ("tracking_valid", "0", "not tracked"),
        ("residual", "-1", "residual below 0"),
        ("occluded", "1", "not tracked"),
    ] {
        let good = if name == "tracking_valid" { "1" } else { "0" };
        let rows = (0..10).map(|index| {
            row(
                index,
                &format!(
                    "{},{}",
                    seen(index),
                    if index == 4 { nothing } else { good }
                ),
            )
        });
        let head = HEAD.replace("qw", &format!("qw,{name}"));
        let table = plainly(&format!("{head}{}", rows.collect::<String>()));
        let body = &table.bodies[0];
        assert_eq!((body.samples.len(), body.unseen.count()), (9, 1), "{name}");
        assert!(body.unseen.words().unwrap().contains(reason), "{name}");
    }
}

#[test]
fn a_trajectory_may_begin_at_the_origin() {
    let rows: String = (0..20)
        .map(|index| {
            format!(
                "{:.2},{},0,0,0,0,0,1\n",
                0.01 * f64::from(index),
                0.002 * f64::from(index)
            )
        })
        .collect();
    let table = plainly(&format!("{HEAD}{rows}"));
    assert_eq!(
        (
            table.bodies[0].samples.len(),
            table.bodies[0].unseen.count()
        ),
        (20, 0)
    );
}

#[test]
fn texts_of_other_shapes_are_read() {
    let plain = timed(|i| format!("{:.2}", 0.01 * i as f64), 5);
    let of_old_macs = plain.replace('\n', "\r");
    assert_eq!(
        plainly(&of_old_macs).bodies[0].samples,
        plainly(&plain).bodies[0].samples
    );
    let decimal = "t,x,y,z,qx,qy,qz,qw\n0,00,1,00,2,00,3,00,0,10,0,50,-0,70,0,50\n0,01,1,00,2,00,3,00,0,10,0,50,-0,70,0,50\n";
    let table = plainly(decimal);
    assert_eq!(
        table.bodies[0].samples[1].quaternion_xyzw,
        [0.1, 0.5, -0.7, 0.5]
    );
    assert!(says(&table.notes, "decimal commas"), "{:?}", table.notes);
    let uneven =
        "t,x,y,z,qx,qy,qz,qw\n0,1,2,3,0,10,0,50,-0,70,0,50\n0,01,1,2,3,0,10,0,50,-0,70,0,50\n";
    assert!(refused(uneven, &TableOptions::default()).contains("are these decimal commas?"));
    let footer = format!("{plain}mean,0,0,0,0,0,0,1\n# end\n");
    let table = plainly(&footer);
    assert_eq!(table.bodies[0].samples.len(), 5);
    assert!(
        says(&table.notes, "1 lines at the end"),
        "{:?}",
        table.notes
    );
    let twice = format!("{plain}{plain}");
    assert!(refused(&twice, &TableOptions::default()).contains("Part the file there"));
}

#[test]
fn an_orientation_that_is_not_read_speaks_against() {
    let text = "t,x,y,z,Euler1,Euler2,Euler3\n0,1,2,3,0,0,0\n0.01,1,2,3,0,0,0\n";
    let table = plainly(text);
    assert!(
        says(
            &table.against,
            "look like an orientation are not read: Euler1"
        ),
        "{:?}",
        table.against
    );
    let plain = plainly("t,x,y,z,temperature\n0,1,2,3,20\n0.01,1,2,3,20\n");
    assert_eq!(plain.against, [""; 0]);
}

#[test]
fn the_unit_of_angles_is_told_by_what_supports_it() {
    let text = |greatest: f64| {
        let row = |index: i32| {
            let share = f64::from(index) / 30.0;
            format!(
                "{},1,2,3,{},{},{}\n",
                0.01 * f64::from(index),
                0.3 * share,
                0.2,
                greatest * share
            )
        };
        let rows: String = (0..=30).map(row).collect();
        format!("t,x,y,z,roll,pitch,yaw\n{rows}")
    };
    for (greatest, unit, is_doubted) in [
        (170.0, "deg", false),
        (2.9, "rad", false),
        (20.0, "deg", true),
        (0.4, "rad", true),
    ] {
        let table = plainly(&text(greatest));
        assert!(
            says(&table.notes, &format!("angles are in {unit}")),
            "{greatest}: {:?}",
            table.notes
        );
        assert_eq!(
            says(&table.against, "--angle-unit"),
            is_doubted,
            "{greatest}: {:?}",
            table.against
        );
    }
}

#[test]
fn every_assumption_has_a_line_of_its_own() {
    let table = plainly(&timed(|i| format!("{:.2}", 0.01 * i as f64), 5));
    for said in ["quaternions are", "axes are", "positions are", "times are"] {
        let lines = table.notes.iter().filter(|line| line.starts_with(said));
        assert_eq!(lines.count(), 1, "{said}: {:?}", table.notes);
    }
}

#[test]
fn norms_that_are_nearly_one_are_made_one_and_others_are_not() {
    let row = |i: usize, scale: f64| {
        let parts = [0.1, 0.5, -0.7, 0.5].map(|of| (of * scale).to_string());
        format!(
            "{:.2},{},2,3,{}\n",
            0.01 * i as f64,
            1.0 + 0.01 * i as f64,
            parts.join(",")
        )
    };
    let text = |scale: f64| {
        format!(
            "{HEAD}{}",
            (0..5).map(|i| row(i, scale)).collect::<String>()
        )
    };
    let norm = |table: &PoseTable| {
        table.bodies[0].samples[3]
            .quaternion_xyzw
            .iter()
            .map(|of| of * of)
            .sum::<f64>()
            .sqrt()
    };
    let near = plainly(&text(1.02));
    assert!((norm(&near) - 1.0).abs() < 1e-12);
    assert!(
        says(&near.bodies[0].notes, "made 1"),
        "{:?}",
        near.bodies[0].notes
    );
    assert!((norm(&plainly(&text(1.25))) - 1.25).abs() < 1e-12);
}
