"""The scripting language of pre- and post-conditions and of Script nodes."""

from bt_manip.bt.script.parser import parse_script as parse_script
