"""The compiled physics of a cell: compiling, caching, overriding and carrying state over."""
