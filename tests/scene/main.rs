//! Scenes as files say them: read, checked, written anew, made from URDF.

mod files;
mod frames;
mod from_urdf;
mod from_urdf_said;
mod tracks;
