//! Stages 2 to 4b as one pure state machine.
