"""Controllers: what turns a reference into torque."""
