"""The command line; its modules import nothing heavy before a command runs.

Each name is imported on first use, since ``--help`` needs few of them.
"""

from typing import TYPE_CHECKING

from bt_manip import lazy_exports

if TYPE_CHECKING:
    from bt_manip.cli.completion import complete_part as complete_part
    from bt_manip.cli.exit_codes import FAILED as FAILED
    from bt_manip.cli.exit_codes import SUCCESS as SUCCESS
    from bt_manip.cli.exit_codes import exit_code_help as exit_code_help
    from bt_manip.cli.options import StationOptions as StationOptions
    from bt_manip.cli.options import takes as takes
    from bt_manip.cli.options import vary_option as vary_option
    from bt_manip.cli.options import workers_option as workers_option
    from bt_manip.cli.plugin_group import PluginGroup as PluginGroup
    from bt_manip.cli.plugin_options import chosen as chosen
    from bt_manip.cli.plugin_options import load_chosen_plugins as load_chosen_plugins
    from bt_manip.cli.tracked_episodes import run_tracked as run_tracked

__getattr__ = lazy_exports(
    __name__,
    {
        "bt_manip.cli.completion": "complete_part",
        "bt_manip.cli.exit_codes": "FAILED SUCCESS exit_code_help",
        "bt_manip.cli.options": "StationOptions takes vary_option workers_option",
        "bt_manip.cli.plugin_group": "PluginGroup",
        "bt_manip.cli.plugin_options": "chosen load_chosen_plugins",
        "bt_manip.cli.tracked_episodes": "run_tracked",
    },
)
