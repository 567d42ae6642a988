//! t
use crate::config::scene_from_toml;
use crate::ingest::Recording;
use crate::pipeline::Pipeline;
#[test]
fn probe() {
    for name in ["pencil_tip", "pencil_eraser"] {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
        let recording = Recording::open(&folder.join(format!("recordings/{name}.mcap"))).unwrap();
        let text = std::fs::read_to_string(folder.join(format!("config/{name}.toml"))).unwrap();
        let scene = scene_from_toml(&text).unwrap();
        let mut pipeline = Pipeline::new(scene.clone());
        for event in recording.take(&scene).unwrap().events { pipeline.push(event); }
        let outcome = pipeline.finish(&mut ()).unwrap();
        println!("{:?} {}", outcome.estimate.verdict, outcome.estimate.reason);
        
        let s = outcome.settled.unwrap();
        println!("from {} end {} rest {} speed {}", s.from_s, s.end_s(), s.at_rest, s.largest_speed_m_s);
        let p = s.bodies[0].poses.last().unwrap(); println!("{:?} axis {:?}", p.translation.vector, p.rotation * nalgebra::Vector3::z());
        let t = std::time::Instant::now();
        let n = 20;
        for _ in 0..n { std::hint::black_box(crate::verify::verify(&scene, &outcome.estimate)); }
        println!("verify {:?}", t.elapsed() / n);
        let t = std::time::Instant::now();
        crate::settle::settle(&scene, &outcome.estimate, 3.0);
        println!("settle {:?}", t.elapsed());
    }
}
