"""All verification cases, suite by suite."""
