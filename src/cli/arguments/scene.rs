//! Arguments of `scene`. Doc comments of the fields are the text of `--help`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use super::calibrate::SceneCalibratedArguments;
use super::values::{Format, rate, triple};

/// The commands of `scene`.
#[derive(Debug, Subcommand)]
pub(in crate::cli) enum SceneCommand {
    /// Make a scene with the mechanism of a URDF file
    FromUrdf(FromUrdfArguments),
    /// Make a scene of an object over a table
    New(NewSceneArguments),
    /// Say what a scene means: bodies, topics, what each mark stands for, what is missing
    Check(CheckSceneArguments),
    /// List the objects that `scene new` knows
    Objects,
    /// List the materials that `scene new --material` knows
    Materials,
    /// Write the JSON schema of scene files to stdout, for editors
    Schema,
    /// Write the reference of scene files to stdout, Markdown
    Reference,
    /// Make a scene with what `calibrate` found
    Calibrated(SceneCalibratedArguments),
}

/// Arguments of `scene new`.
#[derive(Debug, Args)]
pub(in crate::cli) struct NewSceneArguments {
    /// An object of `scene objects`, or a mesh: a file that ends in .obj, .stl or .glb
    #[arg(value_name = "OBJECT")]
    pub(in crate::cli) object: String,
    /// The scene; a file that is there is not replaced [default: the object's name with .toml]
    #[arg(short, long, value_name = "FILE")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// Mass in grams; a mesh needs it [default: that of the object]
    #[arg(long, value_name = "GRAMS", value_parser = rate, allow_hyphen_values = true)]
    pub(in crate::cli) mass_g: Option<f64>,
    /// Unit of length of a mesh [default: m for .glb]
    #[arg(long, value_enum)]
    pub(in crate::cli) unit: Option<LengthUnit>,
    /// Take the convex hull of a mesh, as where its surface is not closed
    #[arg(long)]
    pub(in crate::cli) hull: bool,
    /// How it bounces or rubs, by the name of one of `scene materials` [default: roughly, as is usual for the object]
    #[arg(long, value_name = "NAME")]
    pub(in crate::cli) material: Option<String>,
    /// Sides of a box, die, book or phone in millimetres along its axes [default: those of the object]
    #[arg(long, value_name = "X,Y,Z", value_parser = triple)]
    pub(in crate::cli) size_mm: Option<[f64; 3]>,
    /// Where the tracker is on the object, in millimetres along its axes [default: at its origin]
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    pub(in crate::cli) tracker_mm: Option<[f64; 3]>,
    /// How often it bounces on the table before it lands
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(in crate::cli) bounces: usize,
    /// What the stamps of the performance are
    #[arg(long, value_enum, default_value_t = NewStamps::Tempo)]
    pub(in crate::cli) stamps: NewStamps,
    /// Axis (+z, -x, …) or face that is up when it has come to rest
    #[arg(long, value_name = "UP", allow_hyphen_values = true)]
    pub(in crate::cli) lands: Option<String>,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(in crate::cli) format: Format,
}

/// Units of length of meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum LengthUnit {
    /// Millimetres
    Mm,
    /// Centimetres
    Cm,
    /// Metres
    M,
    /// Inches
    In,
}

impl LengthUnit {
    /// In metres.
    pub(in crate::cli) fn metres(self) -> f64 {
        match self {
            LengthUnit::Mm => 1e-3,
            LengthUnit::Cm => 1e-2,
            LengthUnit::M => 1.0,
            LengthUnit::In => 0.0254,
        }
    }
}

/// What the stamps of a performance are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum NewStamps {
    /// Times of a performance whose tempo is not known
    Tempo,
    /// Times of the motion itself
    Physical,
}

/// Arguments of `scene check`.
#[derive(Debug, Args)]
pub(in crate::cli) struct CheckSceneArguments {
    /// The scene
    #[arg(value_name = "SCENE")]
    pub(in crate::cli) scene: PathBuf,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(in crate::cli) format: Format,
}

/// Arguments of `scene from-urdf`.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n\
             \x20 enact scene from-urdf arm.urdf -o arm.toml")]
pub(in crate::cli) struct FromUrdfArguments {
    /// The robot description, a URDF file
    #[arg(value_name = "IN")]
    pub(in crate::cli) input: PathBuf,
    /// The scene; a file that is there is not replaced [default: IN with .toml]
    #[arg(short, long, value_name = "FILE")]
    pub(in crate::cli) output: Option<PathBuf>,
    /// How the account on stdout is written
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub(in crate::cli) format: Format,
}
