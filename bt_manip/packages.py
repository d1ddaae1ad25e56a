"""The packages that bring options, formats and modules which are not in this one."""

import sys
from typing import Any

PACKAGES = {
    "bt-manip-groot": "--groot --groot-port .btlog .db3 btlog db3 bt_manip.groot",
    "bt-manip-learn": "demos bt_manip.agents bt_manip.demonstrations bt_manip.envs",
    "bt-manip-view": (
        "--view --view-port view replay report video .mp4 .gif mp4 gif "
        "bt_manip.viewer.page bt_manip.viewer.html bt_manip.record.video "
        "bt_manip.viewer.Page bt_manip.viewer.Panel bt_manip.viewer.ReplayPage "
        "bt_manip.record.VideoRecorder bt_manip.record.write_video "
        "bt_manip.evaluation.results_page"
    ),
}
"""By package: options, commands, suffixes, formats, and former modules and names there."""

PACKAGE_OF = {name: package for package, names in PACKAGES.items() for name in names.split()}
"""The package of each of these names."""


def missing(name: str) -> str:
    """Return the end of a message about a name: its package, and how to install it; or nothing."""
    package = PACKAGE_OF.get(name)
    if package is None:
        return ""
    return f"needs the package {package}: pip install ./plugins/{package}"


class MovedModules:
    """Finder of modules that names the package into which one has moved."""

    @staticmethod
    def find_spec(name: str, path: Any = None, target: Any = None) -> None:
        """Find nothing; raise an ImportError for a module, or a name in one, that has moved."""
        if name in PACKAGE_OF:
            package, last = PACKAGE_OF[name].replace("-", "_"), name.rpartition(".")[2]
            new = package if package.endswith(last) else f"{package}.{last}"
            raise ModuleNotFoundError(f"{name} is now {new}, and {missing(name)}", name=name)


def name_moved_modules() -> None:
    """Let imports of modules that have moved name their packages."""
    sys.meta_path.append(MovedModules)
