"""Models of Gazebo Fuel: addresses, the cache shared with Gazebo, and the client."""
