//! TOML → checked scenes and settings.
