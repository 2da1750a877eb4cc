"""Model files: TOML to a model."""
