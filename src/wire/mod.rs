//! Bytes ↔ motion, shared by ingest and write; no files.
