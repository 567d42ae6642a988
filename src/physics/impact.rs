//! How a body bounces: one contact, restitution, with its derivatives.
