//! scratch
use crate::nonsense::{Asked, faults, real};
use crate::results::Options;
use enact::segment;
use std::io::Write;

fn dump(out: &mut impl Write, name: &str, right: bool, seed: u64, asked: &Asked) {
    let outcome = match asked.answered() {
        Ok(o) => o,
        Err(e) => {
            writeln!(out, "{}", serde_json::json!({"name": name, "right": right, "seed": seed, "verdict": "refused", "reason": e.to_string()})).unwrap();
            return;
        }
    };
    let e = &outcome.estimate;
    let marks: Vec<_> = asked
        .events
        .iter()
        .filter_map(|ev| match ev {
            enact::motion::TakeEvent::Mark(m) => Some(m.stamp.seconds_since(outcome.sketch.origin)),
            _ => None,
        })
        .collect();
    let segs = segment::cut(&outcome.scene, &outcome.sketch).unwrap_or_default();
    let mut tm = std::collections::BTreeMap::new();
    for t in &e.sample_times {
        tm.insert((t.body, t.stamp), t.time_s);
    }
    let segments: Vec<_> = segs.iter().map(|s| {
        let samples = &outcome.sketch.bodies[s.body].samples[s.samples.clone()];
        serde_json::json!({"body": s.body, "acted": samples.iter().map(|x| x.acted_s).collect::<Vec<_>>(),
          "phys": samples.iter().map(|x| tm.get(&(s.body, x.stamp)).copied()).collect::<Vec<_>>(),
          "pos": samples.iter().map(|x| [x.position_m.x, x.position_m.y, x.position_m.z]).collect::<Vec<_>>(),
          "quat": samples.iter().map(|x| { let q = x.orientation.quaternion(); [q.w,q.i,q.j,q.k] }).collect::<Vec<_>>()})
    }).collect();
    let v = serde_json::json!({"name": name, "right": right, "seed": seed, "verdict": e.verdict.word(), "reason": e.reason,
      "objective": e.objective, "doubts": e.doubts.iter().map(|d| serde_json::json!([d.about.word(), d.value, d.bound, d.about.best().word()])).collect::<Vec<_>>(),
      "weights": [outcome.scene.weights.position_m, outcome.scene.weights.orientation_rad],
      "gravity0": outcome.scene.gravity_m_s2.as_slice(), "gravity": e.gravity_m_s2.as_slice(),
      "params": e.parameters.iter().map(|p| serde_json::json!([p.name, p.value, p.sd, p.lower, p.upper])).collect::<Vec<_>>(),
      "events": e.events.iter().map(|x| serde_json::json!([x.time_s, x.acted_s, x.sd_s, outcome.scene.events[x.event].kind.word()])).collect::<Vec<_>>(),
      "moved": outcome.counts.marks.moved, "proposed": outcome.counts.marks.proposed,
      "marks": marks,
      "radii": outcome.scene.bodies.iter().map(|b| b.shape.radius_m()).collect::<Vec<_>>(),
      "moments": outcome.scene.bodies.iter().map(|b| b.body.moments_kg_m2().as_slice().to_vec()).collect::<Vec<_>>(),
      "arcs": e.arcs.iter().map(|a| serde_json::json!({"body": a.body, "start": a.start_s, "end": a.end_s, "epoch": a.epoch_s,
         "x": a.state.position_m.as_slice(), "v": a.state.velocity_m_s.as_slice(), "w": a.state.angular_velocity_rad_s.as_slice()})).collect::<Vec<_>>(),
      "res": e.residuals.iter().map(|r| serde_json::json!([r.body, r.samples, r.position_rms_m, r.orientation_rms_rad])).collect::<Vec<_>>(),
      "segments": segments});
    writeln!(out, "{v}").unwrap();
}

pub fn run(options: &Options) -> anyhow::Result<()> {
    let mut out = std::io::BufWriter::new(std::fs::File::create("/tmp/dump.jsonl")?);
    for row in faults::rows() {
        if !options.wants(&row.name) {
            continue;
        }
        for seed in 0..options.seeds {
            match (row.make)(seed) {
                Ok(asked) => dump(&mut out, &row.name, row.is_right, seed, &asked),
                Err(e) => {
                    if seed < 2 {
                        eprintln!("{} {seed}: {e}", row.name)
                    }
                }
            }
        }
    }
    if options.wants("real")
        && let Some(folder) = real::folder()
    {
        for (i, f) in real::files(&folder.join("elbow"), "csv").iter().enumerate() {
            dump(&mut out, "real elbow", false, i as u64, &real::elbow(f));
        }
        for (i, f) in real::files(&folder.join("tosses"), "csv")
            .iter()
            .enumerate()
        {
            if f.file_stem().unwrap().to_str().unwrap().starts_with("toss") {
                dump(&mut out, "real toss", true, i as u64, &real::toss(f, 10));
            }
        }
        for s in ["physical", "tempo"] {
            for (i, f) in real::files(&folder.join("objects"), "csv")
                .iter()
                .enumerate()
            {
                dump(
                    &mut out,
                    &format!("real object {s}"),
                    true,
                    i as u64,
                    &real::object(f, s, 8),
                );
            }
            for (i, a) in real::hovering(&folder.join("mcap/cub_stabilize_2025_11_13.mcap"), s)
                .iter()
                .enumerate()
            {
                dump(&mut out, &format!("real hovering {s}"), false, i as u64, a);
            }
        }
        for (i, f) in real::files(&folder.join("not_throws"), "mcap")
            .iter()
            .enumerate()
        {
            dump(&mut out, "real carried", false, i as u64, &real::carried(f));
        }
    }
    Ok(())
}
