"""The command line; its modules import nothing heavy before a command runs.

Each name is imported on first use, since ``--help`` needs few of them.
"""

from typing import TYPE_CHECKING

from bt_manip import lazy_exports

if TYPE_CHECKING:
    from bt_manip.cli.app import run_app as run_app
    from bt_manip.cli.completion import complete_part as complete_part
    from bt_manip.cli.cycle_table import print_cycles as print_cycles
    from bt_manip.cli.exit_codes import BAD_INPUT as BAD_INPUT
    from bt_manip.cli.exit_codes import FAILED as FAILED
    from bt_manip.cli.exit_codes import INTERRUPTED as INTERRUPTED
    from bt_manip.cli.exit_codes import SUCCESS as SUCCESS
    from bt_manip.cli.exit_codes import exit_code_help as exit_code_help
    from bt_manip.cli.interrupt import Interrupt as Interrupt
    from bt_manip.cli.json_output import findings_of as findings_of
    from bt_manip.cli.json_output import json_option as json_option
    from bt_manip.cli.json_output import print_json as print_json
    from bt_manip.cli.options import GroupedCommand as GroupedCommand
    from bt_manip.cli.options import StationOptions as StationOptions
    from bt_manip.cli.options import given_options as given_options
    from bt_manip.cli.options import takes as takes
    from bt_manip.cli.options import vary_option as vary_option
    from bt_manip.cli.options import workers_option as workers_option
    from bt_manip.cli.plugin_group import PluginGroup as PluginGroup
    from bt_manip.cli.plugin_options import chosen as chosen
    from bt_manip.cli.plugin_options import load_chosen_plugins as load_chosen_plugins
    from bt_manip.cli.plugin_options import print_warning as print_warning
    from bt_manip.cli.run_options import RunOptions as RunOptions
    from bt_manip.cli.session import Session as Session
    from bt_manip.cli.session import execute_run as execute_run
    from bt_manip.cli.tracked_episodes import run_tracked as run_tracked
    from bt_manip.cli.view_options import ViewingCommand as ViewingCommand

__getattr__ = lazy_exports(__name__)
