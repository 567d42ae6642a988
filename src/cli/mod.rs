//! The commands: arguments → a validated job; exit codes.
