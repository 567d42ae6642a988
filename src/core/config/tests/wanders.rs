//! Where the errors of a hand may be a process in time.

use super::super::scene_from_toml;
use super::refusals::refused;
use super::with;
use crate::motion::Performer;

/// The example with physical stamps and a hand that wanders.
fn wandering(stamps: &str) -> String {
    let text = with("stamps = \"tempo\"", &format!("stamps = \"{stamps}\""));
    text.replacen("name = ", "hand = \"wanders\"\nname = ", 1)
}

#[test]
fn a_hand_may_wander_where_stamps_are_physical_times() {
    let scene = scene_from_toml(&wandering("physical")).expect("a valid scene");
    assert_eq!(scene.performer, Performer::Wandering);
}

/// The line that says so.
fn line_of_hand(text: &str) -> usize {
    let at = text.lines().position(|line| line.starts_with("hand"));
    1 + at.expect("a line")
}

#[test]
fn where_it_may_not_is_said_with_what_is_expected() {
    for (stamps, what) in [("edited", "edited stamps"), ("tempo", "by themselves")] {
        let text = wandering(stamps);
        let line = line_of_hand(&text);
        refused(&text, line, "\"wanders\"", what);
        refused(&text, line, "\"wanders\"", "expected hand = \"acted\"");
    }
    let open = wandering("physical").replacen("surface = \"table\"\n", "", 1);
    let line = line_of_hand(&open);
    refused(&open, line, "\"wanders\"", "contacts that are to be found");
    let other = wandering("physical").replacen("wanders", "strays", 1);
    let line = line_of_hand(&other);
    refused(&other, line, "\"strays\"", "\"wanders\" or \"none\"");
}
