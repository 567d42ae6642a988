//! The arguments of `fit`. Doc comments of the fields are the text of `--help`.

use std::path::PathBuf;

use clap::Args;

use super::estimate::Budget;
use super::values::Format;
use crate::service::HoldOut;

/// Arguments of `fit`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n\
             \x20 enact fit takes/*.mcap --shared bounce.restitution -o fit.toml\n\
             \x20 enact fit takes/*.mcap --shared gravity,die.tracker --drawn bounce.restitution --hold-out 0.2 --page fit.html\n\
             \x20 enact scene calibrated scene.toml fit.toml -o fitted.toml")]
pub(in crate::cli) struct FitArguments {
    /// The recordings, MCAP files or folders of them
    #[arg(value_name = "IN", required_unless_present = "solve")]
    pub(in crate::cli) inputs: Vec<PathBuf>,
    /// Quantities that have one value in all takes, by their [[free]] names; a vector or a pair of tilts as a whole by what
    /// they have in common, such as gravity
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    pub(in crate::cli) shared: Vec<String>,
    /// Quantities of which each take draws its own value: mean and spread over takes are found
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    pub(in crate::cli) drawn: Vec<String>,
    /// Takes by which the answer is tried and not made: a share such as 0.2, or files
    #[arg(long, value_name = "SHARE|FILE,…", value_parser = hold_out)]
    pub(in crate::cli) hold_out: Option<HoldOut>,
    /// Scene file for all [default: scene.toml attached to each recording]
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) scene: Option<PathBuf>,
    /// Where the answer goes, TOML for `scene calibrated`; a file that is there is not replaced [default: stdout]
    #[arg(short, long, value_name = "FILE")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Where a page of it goes, HTML
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) page: Option<PathBuf>,
    /// Only makes the block of each take, what it says where the folder asks for it, for --solve; such blocks can be made
    /// anywhere, side by side
    #[arg(long, value_name = "DIR", conflicts_with_all = ["hold_out", "output", "page"])]
    pub(in crate::cli) reduce: Option<PathBuf>,
    /// Joins the blocks in a folder into the answer, or writes there where takes are to be asked next
    #[arg(long, value_name = "DIR", conflicts_with_all = ["inputs", "shared", "drawn", "hold_out", "scene", "reduce"])]
    pub(in crate::cli) solve: Option<PathBuf>,
    #[command(flatten)]
    pub(in crate::cli) budget: Budget,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(in crate::cli) format: Format,
}

fn hold_out(text: &str) -> Result<HoldOut, String> {
    match text.parse::<f64>() {
        Ok(share) if share > 0.0 && share < 1.0 => Ok(HoldOut::Share(share)),
        Ok(_) => Err("expected a share between 0 and 1, or files".into()),
        Err(_) => Ok(HoldOut::Files(text.split(',').map(PathBuf::from).collect())),
    }
}
