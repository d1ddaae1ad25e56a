"""Model files: finding them by address, converting them to MJCF."""

from .address import FoundModel as FoundModel
from .address import Source as Source
from .address import built_in_sources as built_in_sources
from .address import bundled_names as bundled_names
from .address import find_model as find_model
from .address import is_address as is_address
from .bundled import bundled_path as bundled_path
from .bundled import bundled_root as bundled_root
from .convex import can_decompose as can_decompose
from .downloads import no_downloads as no_downloads
from .errors import ModelError as ModelError
from .exact_xml import exact_xml as exact_xml
from .load import load_model as load_model
from .menagerie import is_cached as is_cached
from .menagerie import menagerie_file as menagerie_file
from .menagerie import menagerie_names as menagerie_names
from .menagerie import remove as remove
from .mjcf_files import check_mjcf as check_mjcf
from .mjcf_model import MjcfModel as MjcfModel
from .progress import Progress as Progress
from .progress import terminal_progress as terminal_progress
