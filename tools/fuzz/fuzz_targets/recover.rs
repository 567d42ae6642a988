//! Any bytes as a journal: it is kept, and what is recovered of it is a recording without damage.
#![no_main]

mod desk;

use enact::wire::container::Container;
use enact::write::recover;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let part = desk::file("take.mcap.part", bytes);
    match recover(&part) {
        Ok(recovered) => {
            assert!(std::fs::read(&recovered.journal).expect("kept") == bytes);
            let recording = std::fs::read(&recovered.path).expect("a recording");
            let container = Container::new(recording).expect("MCAP");
            assert!(!container.damages().is_loss(), "{:?}", container.damages());
            let said: u64 = recovered.topics.iter().map(|(_, messages)| messages).sum();
            assert_eq!(container.message_count(), said);
        }
        Err(_) => assert!(std::fs::read(&part).expect("kept") == bytes),
    }
});
