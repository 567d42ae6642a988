//! Any bytes as a recording that marks are added to, and as one whose estimate is exported: what could
//! be read comes out, and what is written can be read.
#![no_main]

mod desk;

use std::collections::BTreeSet;

use enact::ingest::Recording;
use enact::motion::{Mark, Stamp};
use enact::service::{ExportFormat, ExportJob, export};
use enact::wire::container::Container;
use enact::write::write_marks;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let input = desk::file("in.mcap", bytes);
    let Ok(recording) = Recording::from_bytes(&input, bytes.to_vec()) else {
        return;
    };
    let output = input.with_file_name("out.mcap");
    let mark = Mark {
        stamp: Stamp(5),
        event: None,
    };
    let marks = [(Stamp(7), mark)];
    let (container, none) = (recording.container(), BTreeSet::new());
    if write_marks(&output, container, &input, "/marks", &marks, none).is_ok() {
        let written = std::fs::read(&output).expect("written");
        let written = Container::new(written).expect("MCAP");
        assert!(!written.damages().is_loss(), "{:?}", written.damages());
        let before = recording.container().message_count();
        assert!(written.message_count() >= before.min(1), "{before}");
    }
    for format in [
        ExportFormat::Glb,
        ExportFormat::Csv,
        ExportFormat::Tum,
        ExportFormat::Ros2,
    ] {
        let job = ExportJob {
            input: input.clone(),
            output: Some(input.with_file_name("out")),
            format,
            frame_rate_hz: 1.0,
            with_acted: true,
            command: String::new(),
        };
        let _ = std::hint::black_box(export(&job));
    }
});
