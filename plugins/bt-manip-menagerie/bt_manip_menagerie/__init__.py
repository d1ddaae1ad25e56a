"""Arms and grippers of MuJoCo Menagerie, described for bt-manip."""

from .plugin import description_files as description_files
