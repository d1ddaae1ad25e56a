"""Motion: inverse kinematics, trajectories and the arm that follows them."""
