"""A server of the Model Context Protocol, by which assistants check, run and repair trees."""
