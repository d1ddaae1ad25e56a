"""Hooks of this package."""

from bt_manip import hookimpl


@hookimpl
def register_robots(register):
    """Bring the robots; their models are fetched when one of them is used."""
    from bt_manip.robots import read_description
    from bt_manip_menagerie.descriptions import description_files

    for path in description_files():
        register(read_description(path))
