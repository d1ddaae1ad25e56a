"""The tree language: nodes, ports, scoped blackboard, scripting, XML in and out."""
