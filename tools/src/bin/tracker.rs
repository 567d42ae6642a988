//! A tracker to play with: publishes a recording, or a performance made on the spot, on
//! iceoryx2, with faults on request.
//!
//! ```text
//! cargo run --release -p enact-tools --bin tracker -- recordings/pencil_tip.mcap --take
//! cargo run --release -p enact-tools --bin tracker -- recordings/pencil_tip.mcap --take --rate 4 --freeze 50..80
//! cargo run --release -p enact-tools --bin tracker -- --perform tip --seed 3 --distortion 2 --take
//! cargo run --release -p enact-tools --bin tracker -- --load 8 --rate-hz 1000 --seconds 600 --take
//! ```

use clap::Parser;
use enact_tools::tracker;

fn main() -> anyhow::Result<()> {
    let sent = tracker::run(&tracker::Arguments::parse())?;
    // One line for scripts: what a daemon must have received.
    println!("{}", serde_json::to_string(&sent)?);
    Ok(())
}
