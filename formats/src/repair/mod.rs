//! Clean-up that several importers share.
