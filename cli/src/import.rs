//! Reads cuts, meshes and environments from files.
