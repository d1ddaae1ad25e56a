"""Control nodes and decorators of Nav2."""
